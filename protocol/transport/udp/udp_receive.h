// Batched receive (recvmmsg) and delivery of pose parts, shared by all UDP listeners.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/inbox.h"

namespace fire3dv::transport::udp {

// Tracks the received parts of frames: reports complete frames, duplicates, and parts of superseded frames.
class FrameTracker {
 public:
  // repeated: duplicate part.
  enum class Outcome { superseded, repeated, part, whole };
  Outcome part(uint64_t frame, uint16_t part, bool last);
  uint64_t newest_whole() const { return newest_whole_; }
  // Counts a partial frame, whose whole form need not follow.
  void partial() { ++partials_; }
  // Number of lost frames between the previous complete frame and the newest one.
  uint64_t missed(uint64_t newest_before) {
    const uint64_t gap = newest_whole_ - newest_before - 1;
    return gap - std::min(gap, std::exchange(partials_, 0));
  }

 private:
  struct Building {
    uint64_t frame = 0;
    uint32_t count = 0;              // received parts
    uint32_t total = 0;              // 0 until the last part is received
    std::vector<uint64_t> received;  // bitmap by part
  };
  static constexpr size_t kMaxBuilding = 8;

  std::vector<Building> building_;
  uint64_t newest_whole_ = 0;
  uint64_t partials_ = 0;
};

// Enlarges the socket's receive buffer to hold the burst of a large frame.
void widen_receive_buffer(int fd);

// Receives the pending datagrams, with a bound per call.
using OnDatagram = std::function<void(const Address& from, std::span<std::byte> datagram, int64_t now_ns)>;
void receive_all(int fd, LinkCounters& counters, const OnDatagram& on_datagram);

// Queues the payload of one pose datagram in the inbox. repeated: a duplicate.
enum class PoseArrival { delivered, repeated };
PoseArrival deliver_pose(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                         FrameTracker& frames, std::span<const std::byte> payload);

}  // namespace fire3dv::transport::udp
