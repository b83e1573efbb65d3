// A recording on a thread of its own: whoever hands messages over never waits for packing or for a disk.
// Beyond a bound what comes is left out and counted.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "protocol/record/stream_log.h"

namespace fire3dv::record {

struct LogStatus {
  std::vector<StreamSeen> streams;
  uint64_t file_bytes = 0;
  uint32_t files = 0;
  uint64_t refused = 0;
  uint64_t unkept_edits = 0;
  uint64_t reclaimed_streams = 0, reclaimed_frames = 0;  // in the files, and not in `streams`
  uint64_t unrecorded_streams = 0;
  uint64_t unwritten = 0;  // messages that came while the disk was too slow, or that it did not take
  std::optional<std::string> failure;
};

// Losses of a recording, without the counts of its streams.
struct LogLosses {
  uint64_t unwritten = 0, unrecorded_streams = 0;
  std::optional<std::string> failure;
};

class LogThread {
 public:
  // most_queued_bytes: what is not written yet. Poses beyond it are left out; what is not a pose may take
  // twice as much.
  explicit LogThread(StreamLog log, uint64_t most_queued_bytes = uint64_t{256} << 20);
  ~LogThread();

  // monotonic_ns: when it came.
  void take(uint64_t peer, std::span<const std::byte> message, int64_t monotonic_ns, bool is_pose);
  void end_peer(uint64_t peer, int64_t monotonic_ns);
  // Writes what is left, finishes the file, and flushes it to the disk.
  void finish();
  // As of the last turn of the thread, ten a second at least; unwritten as of now.
  LogStatus status() const;
  LogLosses losses() const;
  // Whether losses() has any. One atomic load: suitable for every frame.
  bool has_trouble() const { return trouble_; }

 private:
  struct Incoming {
    uint64_t peer = 0;
    uint64_t log_time_ns = 0;
    Bytes message;  // empty: the peer is gone
    uint64_t bytes() const { return message.size() + sizeof(Incoming); }
  };

  static uint64_t messages_in(const std::deque<Incoming>& queue);
  void push(Incoming incoming, bool may_drop);
  uint64_t unix_ns(int64_t monotonic_ns) const;
  void run();
  void give_back(uint64_t bytes);

  const int64_t monotonic_at_start_ns_, unix_at_start_ns_;
  const uint64_t most_queued_bytes_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Incoming> queue_;
  uint64_t queued_bytes_ = 0;  // of queue_, and of what the thread is writing
  bool over_ = false;
  uint64_t dropped_ = 0;
  std::atomic<bool> trouble_{false};
  LogStatus status_;

  StreamLog log_;  // of the thread alone, from its start on
  std::thread thread_;
};

}  // namespace fire3dv::record
