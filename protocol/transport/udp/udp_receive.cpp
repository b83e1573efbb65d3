#include "protocol/transport/udp/udp_receive.h"

#include <sys/socket.h>

#include <vector>

#include "protocol/base/clock.h"
#include "protocol/transport/udp/udp_datagram.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int kBatch = 32;
constexpr int kMostBatchesATurn = 16;
constexpr int kReceiveBufferBytes = 8 << 20;
constexpr size_t kMostWaitingPoseBytes = 64 << 20;

}  // namespace

void widen_receive_buffer(int fd) {
  // The first call may go above the system's limit, for root alone.
  if (::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &kReceiveBufferBytes, sizeof kReceiveBufferBytes) != 0)
    ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &kReceiveBufferBytes, sizeof kReceiveBufferBytes);
}

void receive_all(int fd, LinkCounters& counters, const OnDatagram& on_datagram) {
  static thread_local std::byte buffers[kBatch][kMaxDatagramBytes + 1];
  Address from[kBatch];
  iovec pieces[kBatch];
  mmsghdr messages[kBatch];
  for (int batch = 0; batch < kMostBatchesATurn; ++batch) {
    for (int i = 0; i < kBatch; ++i) {
      pieces[i] = {buffers[i], sizeof buffers[i]};
      messages[i] = {};
      messages[i].msg_hdr.msg_name = from[i].get();
      messages[i].msg_hdr.msg_namelen = sizeof from[i].storage;
      messages[i].msg_hdr.msg_iov = &pieces[i];
      messages[i].msg_hdr.msg_iovlen = 1;
    }
    const int got = ::recvmmsg(fd, messages, kBatch, MSG_DONTWAIT, nullptr);
    const int64_t now_ns = monotonic_ns();
    for (int i = 0; i < got; ++i) {
      from[i].length = messages[i].msg_hdr.msg_namelen;
      counters.bytes_received.add(messages[i].msg_len);
      on_datagram(from[i], {buffers[i], messages[i].msg_len}, now_ns);
    }
    if (got < kBatch) return;
  }
}

PoseArrival take_pose(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                      FrameTracker& frames, std::span<const std::byte> payload) {
  PoseHeader header;
  if (!read_pose_header(payload, header)) {
    counters.reject(Cause::malformed);
    return PoseArrival::taken;
  }
  const std::span<const std::byte> message = payload.subspan(kPoseHeaderBytes);
  const bool newest = delivery == Delivery::newest;
  if (header.partial) {
    if (header.frame > frames.newest_whole()) frames.partial();
    inbox.partial_pose(peer, std::vector<std::byte>(message.begin(), message.end()), header.frame);
    return PoseArrival::taken;
  }
  const uint64_t newest_before = frames.newest_whole();
  const auto outcome = frames.part(header.frame, header.part, header.last);
  if (outcome == FrameTracker::Outcome::repeated) return PoseArrival::repeated;
  if (outcome == FrameTracker::Outcome::whole && newest_before != 0)
    counters.frames_dropped.add(frames.missed(newest_before));
  if (newest && outcome == FrameTracker::Outcome::superseded) {
    counters.poses_dropped.add();
    return PoseArrival::taken;
  }
  if (newest && outcome == FrameTracker::Outcome::whole) inbox.drop_parts_before(peer, header.frame);
  if (inbox.waiting(peer).bytes > kMostWaitingPoseBytes) {
    // Nobody polls and no frame gets whole: the newest is what is worth keeping.
    if (!newest) {
      counters.poses_dropped.add();
      return PoseArrival::taken;
    }
    inbox.drop_parts_before(peer, header.frame);
  }
  inbox.pose_part(peer, std::vector<std::byte>(message.begin(), message.end()), header.frame,
                  !newest || outcome == FrameTracker::Outcome::whole);
  return PoseArrival::taken;
}

}  // namespace fire3dv::transport::udp
