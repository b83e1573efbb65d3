// Batched receipt of datagrams, and delivery of the pose parts in them. Common to all UDP listeners.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/inbox.h"
#include "protocol/transport/udp/udp_window.h"

namespace fire3dv::transport::udp {

// A burst of a large frame has to fit the socket's buffer.
void widen_receive_buffer(int fd);

// Takes what waits at the socket, but no more than a turn's share.
using OnDatagram = std::function<void(const Address& from, std::span<std::byte> datagram, int64_t now_ns)>;
void receive_all(int fd, LinkCounters& counters, const OnDatagram& on_datagram);

// Hands one pose datagram's payload on. `repeated`: it came before.
enum class PoseArrival { taken, repeated };
PoseArrival take_pose(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                      FrameTracker& frames, std::span<const std::byte> payload);

}  // namespace fire3dv::transport::udp
