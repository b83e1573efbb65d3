#include "protocol/transport/udp/udp_receive.h"

#include <sys/socket.h>

#include <algorithm>
#include <vector>

#include "protocol/base/clock.h"
#include "protocol/transport/udp/udp_datagram.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int kBatch = 32;
constexpr int kMaxBatches = 16;
constexpr int kReceiveBufferBytes = 8 << 20;
constexpr size_t kMaxWaitingPoseBytes = 64 << 20;

}  // namespace

FrameTracker::Outcome FrameTracker::part(uint64_t frame, uint16_t part, bool last) {
  if (frame == newest_whole_) return Outcome::repeated;
  if (frame < newest_whole_) return Outcome::superseded;
  auto building =
      std::find_if(building_.begin(), building_.end(), [&](const Building& b) { return b.frame == frame; });
  if (building == building_.end()) {
    if (building_.size() == kMaxBuilding) {
      const auto oldest = std::min_element(building_.begin(), building_.end(),
                                           [](const auto& a, const auto& b) { return a.frame < b.frame; });
      if (oldest->frame > frame) return Outcome::superseded;
      building_.erase(oldest);
    }
    building_.push_back({frame, 0, 0, {}});
    building = building_.end() - 1;
  }
  if (building->received.size() <= part / 64u) building->received.resize(part / 64u + 1);
  uint64_t& word = building->received[part / 64u];
  const uint64_t bit = uint64_t{1} << (part % 64u);
  if ((word & bit) != 0) return Outcome::repeated;
  word |= bit;
  ++building->count;
  if (last) building->total = uint32_t{part} + 1;
  if (building->total == 0 || building->count < building->total) return Outcome::part;
  newest_whole_ = frame;
  std::erase_if(building_, [&](const Building& b) { return b.frame <= frame; });
  return Outcome::whole;
}

void widen_receive_buffer(int fd) {
  // SO_RCVBUFFORCE exceeds the system's limit, but requires CAP_NET_ADMIN.
  if (::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &kReceiveBufferBytes, sizeof kReceiveBufferBytes) != 0)
    ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &kReceiveBufferBytes, sizeof kReceiveBufferBytes);
}

void receive_all(int fd, LinkCounters& counters, const OnDatagram& on_datagram) {
  static thread_local std::byte buffers[kBatch][kMaxDatagramBytes + 1];
  Address from[kBatch];
  iovec pieces[kBatch];
  mmsghdr messages[kBatch];
  for (int batch = 0; batch < kMaxBatches; ++batch) {
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

PoseArrival deliver_pose(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                         FrameTracker& frames, std::span<const std::byte> payload) {
  PoseHeader header;
  if (!read_pose_header(payload, header)) {
    counters.reject(Cause::malformed);
    return PoseArrival::delivered;
  }
  const std::span<const std::byte> message = payload.subspan(kPoseHeaderBytes);
  const bool newest = delivery == Delivery::newest;
  if (header.partial) {
    if (header.frame > frames.newest_whole()) frames.partial();
    inbox.partial_pose(peer, std::vector<std::byte>(message.begin(), message.end()), header.frame);
    return PoseArrival::delivered;
  }
  const uint64_t newest_before = frames.newest_whole();
  const auto outcome = frames.part(header.frame, header.part, header.last);
  if (outcome == FrameTracker::Outcome::repeated) return PoseArrival::repeated;
  if (outcome == FrameTracker::Outcome::whole && newest_before != 0)
    counters.frames_dropped.add(frames.missed(newest_before));
  if (newest && outcome == FrameTracker::Outcome::superseded) {
    counters.poses_dropped.add();
    return PoseArrival::delivered;
  }
  if (newest && outcome == FrameTracker::Outcome::whole) inbox.drop_parts_before(peer, header.frame);
  if (inbox.waiting(peer).bytes > kMaxWaitingPoseBytes) {
    // The receiver does not poll and no frame is complete: drops all but the newest.
    if (!newest) {
      counters.poses_dropped.add();
      return PoseArrival::delivered;
    }
    inbox.drop_parts_before(peer, header.frame);
  }
  inbox.pose_part(peer, std::vector<std::byte>(message.begin(), message.end()), header.frame,
                  !newest || outcome == FrameTracker::Outcome::whole);
  return PoseArrival::delivered;
}

}  // namespace fire3dv::transport::udp
