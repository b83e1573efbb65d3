// Background recorder: writes a StreamLog on its own thread. Callers never wait for compression or disk I/O.
// Messages beyond the queue limit are dropped and counted.
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
  uint64_t dropped_edits = 0;
  uint64_t reclaimed_streams = 0, reclaimed_frames = 0;  // in the files, but not in `streams`
  uint64_t unrecorded_streams = 0;
  uint64_t unwritten = 0;  // messages dropped because the disk was too slow or failed
  std::optional<std::string> failure;
  uint64_t unconverted_markers = 0;       // missing in Foxglove's channels
  uint64_t reclaimed_missing = 0;         // frames that reclaimed streams lack
  std::optional<std::string> name_fault;  // see StreamLog::name_fault()
};

// Losses of a recording, without the per-stream counts.
struct LogLosses {
  uint64_t unwritten = 0, unrecorded_streams = 0;
  std::optional<std::string> failure, name_fault;
};

// Numbers of missing and incomplete frames of each stream, in one sentence; nothing if the recording has all
// frames.
std::optional<std::string> describe_gaps(const LogStatus& status);

class LogThread {
 public:
  // max_queued_bytes limits the bytes that are not written yet. Poses beyond it are dropped; other messages
  // may use twice as much.
  explicit LogThread(StreamLog log, uint64_t max_queued_bytes = uint64_t{256} << 20);
  ~LogThread();

  // at_ns: arrival time on the monotonic clock. Any thread. Without effect after finish().
  void take(uint64_t peer, std::span<const std::byte> message, int64_t at_ns, bool is_pose);
  void end_peer(uint64_t peer, int64_t at_ns);
  // Writes the queue, finishes the file, and flushes it to the disk.
  void finish();
  // State as of the thread's last iteration (at least ten per second); `unwritten` is current.
  LogStatus status() const;
  LogLosses losses() const;
  // True if losses() has any. One atomic load: cheap enough for every frame.
  bool has_trouble() const { return trouble_; }

 private:
  struct Incoming {
    uint64_t peer = 0;
    uint64_t log_time_ns = 0;
    Bytes message;  // empty: end of the peer
    uint64_t bytes() const { return message.size() + sizeof(Incoming); }
  };

  static uint64_t messages_in(const std::deque<Incoming>& queue);
  void push(Incoming incoming, bool may_drop);
  uint64_t unix_ns(int64_t at_ns) const;
  void run();
  void write_until_over();
  void give_back(uint64_t bytes);

  const int64_t monotonic_at_start_ns_, unix_at_start_ns_;
  const uint64_t max_queued_bytes_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Incoming> queue_;
  uint64_t queued_bytes_ = 0;  // includes messages that the thread is writing
  bool over_ = false;
  uint64_t dropped_ = 0;
  std::atomic<bool> trouble_{false};
  LogStatus status_;

  StreamLog log_;  // used only by the thread once it runs
  std::thread thread_;
};

}  // namespace fire3dv::record
