// Takes what links bring and hands it to a thread that packs and writes: a ring in shared memory holds some
// frames only, and a disk may stand still for longer than they last.
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
#include "protocol/transport/link.h"

namespace fire3dv::record {

struct RecorderStatus {
  std::vector<StreamSeen> streams;
  uint64_t file_bytes = 0;
  uint32_t files = 0;
  uint64_t refused = 0;
  uint64_t unkept_edits = 0;
  uint64_t unwritten = 0;  // messages that came while the disk was too slow, or that it did not take
  std::optional<std::string> failure;
};

class Recorder {
 public:
  explicit Recorder(StreamLog log);
  ~Recorder();

  // Takes what has come over the link. Never waits for the disk. answers: the publisher has nobody else to
  // talk to.
  void poll(transport::ListenerLink& link, uint32_t link_number, bool answers);
  // Writes what is left, and finishes the file.
  void finish();
  RecorderStatus status() const;

 private:
  struct Incoming {
    uint64_t peer = 0;
    uint64_t log_time_ns = 0;
    wire::Bytes message;  // empty: the peer is gone
  };

  void push(Incoming incoming, bool may_drop);
  void answer(transport::ListenerLink& link, transport::PeerId peer, std::span<const std::byte> message);
  uint64_t unix_ns(int64_t monotonic_ns) const;
  void run();

  int64_t monotonic_at_start_ns_, unix_at_start_ns_;
  wire::Decoder decoder_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Incoming> queue_;
  uint64_t queued_bytes_ = 0;
  bool over_ = false;
  RecorderStatus status_;
  std::atomic<uint64_t> dropped_{0};

  StreamLog log_;  // of the thread alone, from its start on
  std::thread thread_;
};

}  // namespace fire3dv::record
