// Atomic counters of LinkStats. Readable on any thread; counters with several writers use fetch_add.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "protocol/transport/link.h"
#include "protocol/wire/limits.h"

namespace fire3dv::transport {

class Counter {
 public:
  void add(uint64_t amount = 1) { value_.fetch_add(amount, std::memory_order_relaxed); }
  // For counters with a single writer: no locked instruction.
  void add_alone(uint64_t amount) { set(get() + amount); }
  void set(uint64_t value) { value_.store(value, std::memory_order_relaxed); }
  uint64_t get() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<uint64_t> value_{0};
};

struct LinkCounters {
  Counter messages_sent, messages_received, bytes_sent, bytes_received, poses_dropped, frames_dropped, peers;
  Counter images_sent, images_received, images_dropped;
  std::array<Counter, kCauseCount> rejected;

  void reject(Cause cause, uint64_t amount = 1) { rejected[static_cast<size_t>(cause)].add(amount); }

  LinkStats snapshot() const {
    LinkStats stats;
    stats.messages_sent = messages_sent.get();
    stats.messages_received = messages_received.get();
    stats.bytes_sent = bytes_sent.get();
    stats.bytes_received = bytes_received.get();
    stats.poses_dropped = poses_dropped.get();
    stats.frames_dropped = frames_dropped.get();
    stats.images_sent = images_sent.get();
    stats.images_received = images_received.get();
    stats.images_dropped = images_dropped.get();
    for (size_t i = 0; i < kCauseCount; ++i) {
      stats.rejected_by_cause[i] = rejected[i].get();
      stats.rejected += stats.rejected_by_cause[i];
    }
    stats.peers = static_cast<uint32_t>(peers.get());
    return stats;
  }
};

using wire::kMaxMessageBytes;

}  // namespace fire3dv::transport
