#include "protocol/transport/udp/udp_poses.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/clock.h"
#include "protocol/transport/core/byte_order.h"
#include "protocol/transport/udp/udp_datagram.h"

namespace fire3dv::transport::udp {
namespace {

// 1,300,000 poses: more than a description may contain.
constexpr size_t kMaxCacheBytes = 64 << 20;
constexpr int64_t kFirstRepeatNs = 30'000'000;
constexpr int64_t kLastRepeatNs = 250'000'000;
// A burst must fit a receive buffer of default size, or a repetition would lose the same datagrams again.
constexpr size_t kBurst = 64;
constexpr int64_t kBurstEveryNs = 5'000'000;

}  // namespace

PoseSender::Outcome PoseSender::publish(int fd, Session* session, const wire::MessagePieces& message,
                                        bool last_part, int64_t now_ns, Drops& drops) {
  if (part_ == 0) {
    drops = drop_queued();
    ++frame_;
  }
  const bool fits = message.size() <= max_message_bytes_ && part_ <= UINT16_MAX && !lost_part_;
  const PoseHeader header{frame_, static_cast<uint16_t>(part_), last_part};
  part_ = last_part ? 0 : part_ + 1;
  complete_ = last_part;
  if (!fits || !append_payload(header, message)) {
    ++drops.messages;
    if (!lost_part_) ++drops.frames;
    lost_part_ = true;
    return Outcome::dropped;
  }
  repeat_after_ns_ = kFirstRepeatNs;
  repeat_at_ns_ = now_ns + repeat_after_ns_;
  const bool may_send = session != nullptr && next_ + 1 >= ends_.size();
  Outcome outcome = Outcome::queued;
  if (may_send) {
    outcome = send(fd, *session, next_);
    if (outcome == Outcome::sent) {
      ++next_;
      has_base_ = has_base_ || (complete_ && !lost_part_);
    }
  }
  if (session != nullptr && complete_ && parity_.is_on()) append_parity();
  while (outcome == Outcome::sent && next_ < ends_.size() && send(fd, *session, next_) == Outcome::sent)
    ++next_;
  if (may_send && next_ < ends_.size()) repeat_at_ns_ = now_ns + kBurstEveryNs;
  return outcome;
}

PoseSender::Outcome PoseSender::publish_partial(int fd, Session* session, const wire::MessagePieces& partial,
                                                std::span<const wire::MessagePieces> whole, int64_t now_ns,
                                                Drops& drops) {
  part_ = 0;
  drops = drop_queued();
  ++frame_;
  Outcome outcome = Outcome::queued;
  if (session != nullptr && has_base_ && partial.size() <= max_message_bytes_) {
    std::byte payload[kMaxDatagramBytes];
    write_pose_header(payload, {frame_, 0, true, true});
    std::copy(partial.head.begin(), partial.head.end(), payload + kPoseHeaderBytes);
    std::copy(partial.body.begin(), partial.body.end(), payload + kPoseHeaderBytes + partial.head.size());
    outcome = send_bytes(fd, *session, Type::pose, {payload, kPoseHeaderBytes + partial.size()});
  }
  // The listener acknowledges whole frames only.
  for (size_t part = 0; part < whole.size(); ++part) {
    const bool last = part + 1 == whole.size();
    if (part <= UINT16_MAX && whole[part].size() <= max_message_bytes_ &&
        append_payload({frame_, static_cast<uint16_t>(part), last, false}, whole[part]))
      continue;
    drops.messages += whole.size() - part;
    ++drops.frames;
    payloads_.clear();
    ends_.clear();
    data_count_ = 0;
    return outcome == Outcome::sent ? outcome : Outcome::dropped;
  }
  complete_ = true;
  repeat_after_ns_ = kFirstRepeatNs;
  repeat_at_ns_ = now_ns;
  if (outcome == Outcome::sent) {
    next_ = ends_.size();
    first_round_ = false;
    repeat_at_ns_ = now_ns + repeat_after_ns_;
  } else if (session != nullptr && outcome != Outcome::refused) {
    if (parity_.is_on()) append_parity();
    emit_due(fd, *session, now_ns);
    if (next_ >= data_count_) outcome = Outcome::sent;
  }
  return outcome;
}

// A datagram that the socket rejects stays queued.
PoseSender::Outcome PoseSender::send(int fd, Session& session, size_t index) {
  const size_t start = index == 0 ? 0 : ends_[index - 1];
  return send_bytes(fd, session, index < data_count_ ? Type::pose : Type::parity,
                    {payloads_.data() + start, ends_[index] - start});
}

PoseSender::Outcome PoseSender::send_bytes(int fd, Session& session, Type type,
                                           std::span<const std::byte> payload) {
  Session::Buffer datagram;
  session.start(datagram, type);
  ssize_t sent;
  if (session.sealed()) {
    std::memcpy(datagram.data() + kHeaderBytes, payload.data(), payload.size());
    const auto whole = session.finish(datagram, kHeaderBytes + payload.size());
    if (whole.empty()) return Outcome::queued;
    sent = ::send(fd, whole.data(), whole.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  } else {
    iovec pieces[2] = {{datagram.data(), kHeaderBytes},
                       {const_cast<std::byte*>(payload.data()), payload.size()}};
    msghdr gathered{};
    gathered.msg_iov = pieces;
    gathered.msg_iovlen = 2;
    sent = ::sendmsg(fd, &gathered, MSG_DONTWAIT | MSG_NOSIGNAL);
  }
  if (sent >= 0) {
    bytes_sent_ += static_cast<uint64_t>(sent);
    return Outcome::sent;
  }
  return errno == ECONNREFUSED ? Outcome::refused : Outcome::queued;
}

bool PoseSender::append_payload(const PoseHeader& header, const wire::MessagePieces& message) {
  const size_t at = payloads_.size();
  const size_t end = at + kPoseHeaderBytes + message.size();
  if (end > kMaxCacheBytes) return false;
  if (ends_.size() == ends_.capacity())
    ends_.reserve(2 * ends_.size() + 64);  // the steps below must not throw half-way
  payloads_.resize(end);
  write_pose_header(&payloads_[at], header);
  std::copy(message.head.begin(), message.head.end(),
            payloads_.begin() + static_cast<std::ptrdiff_t>(at + kPoseHeaderBytes));
  std::copy(message.body.begin(), message.body.end(),
            payloads_.end() - static_cast<std::ptrdiff_t>(message.body.size()));
  ends_.push_back(end);
  ++data_count_;
  return true;
}

// Appends the parity of the whole frame. Rows go round the groups, so that a burst of losses spreads.
void PoseSender::append_parity() {
  const auto parts = static_cast<uint32_t>(data_count_);
  const uint32_t groups = parity_groups(parts);
  plan_.assign(groups, {});
  size_t most_rows = 0, added_bytes = 0, added = 0;
  const auto message = [this](size_t part) {
    const size_t begin = (part == 0 ? 0 : ends_[part - 1]) + kPoseHeaderBytes;
    return std::span(payloads_).subspan(begin, ends_[part] - begin);
  };
  for (uint32_t group = 0; group < groups; ++group) {
    GroupPlan& plan = plan_[group];
    plan.rows = parity_.symbols(parts_of_group(parts, group));
    most_rows = std::max(most_rows, plan.rows);
    for (size_t part = group; part < parts; part += groups)
      plan.symbol_bytes = std::max(plan.symbol_bytes, 2 + message(part).size());
    added += plan.rows;
    added_bytes += plan.rows * (kParityHeaderBytes + plan.symbol_bytes);
  }
  if (added == 0 || payloads_.size() + added_bytes > kMaxCacheBytes) return;
  ends_.reserve(ends_.size() + added);
  payloads_.reserve(payloads_.size() + added_bytes);
  for (size_t row = 0; row < most_rows; ++row) {
    for (uint32_t group = 0; group < groups; ++group) {
      if (row >= plan_[group].rows) continue;
      const size_t at = payloads_.size();
      payloads_.resize(at + kParityHeaderBytes + plan_[group].symbol_bytes);
      write_parity_header(&payloads_[at],
                          {frame_, parts, static_cast<uint16_t>(group), static_cast<uint8_t>(row)});
      const auto symbol = std::span(payloads_).subspan(at + kParityHeaderBytes);
      size_t column = 0;
      for (size_t part = group; part < parts; part += groups, ++column) {
        std::byte length[2];
        put_le<uint16_t>(length, static_cast<uint16_t>(message(part).size()));
        const uint8_t factor = parity_factor(row, column);
        gf_multiply_add(symbol, length, factor);
        gf_multiply_add(symbol.subspan(2), message(part), factor);
      }
      ends_.push_back(payloads_.size());
    }
  }
}

void PoseSender::emit_due(int fd, Session& session, int64_t now_ns) {
  if (acknowledged_ || ends_.empty()) return;
  if (next_ >= round_end()) {
    if (!complete_ || now_ns < repeat_at_ns_) return;
    next_ = 0;
    first_round_ = false;
  }
  const size_t end = std::min(round_end(), next_ + kBurst);
  while (next_ < end && send(fd, session, next_) == Outcome::sent) ++next_;
  repeat_at_ns_ = now_ns + (next_ < round_end() ? kBurstEveryNs : repeat_after_ns_);
  has_base_ = has_base_ || (next_ >= data_count_ && complete_);
  if (next_ >= round_end()) repeat_after_ns_ = std::min(2 * repeat_after_ns_, kLastRepeatNs);
}

std::optional<int64_t> PoseSender::due_at_ns() const {
  if (acknowledged_ || ends_.empty() || (next_ >= round_end() && !complete_)) return {};
  return repeat_at_ns_;
}

void PoseSender::acknowledge(uint64_t frame) {
  if (frame == frame_ && complete_) acknowledged_ = true;
}

void PoseSender::start_session() {
  if (next_ >= data_count_) first_round_ = false;
  parity_.start_session();
  acknowledged_ = has_base_ = false;
  next_ = 0;
  repeat_at_ns_ = 0;
  repeat_after_ns_ = kFirstRepeatNs;
}

PoseSender::Drops PoseSender::unsent() const {
  if (!first_round_ || acknowledged_) return {};
  const uint64_t messages = data_count_ - std::min(next_, data_count_);
  return {messages, messages != 0 && !lost_part_ ? 1u : 0u};
}

PoseSender::Drops PoseSender::start_description() {
  has_base_ = false;
  return drop_queued();
}

PoseSender::Drops PoseSender::drop_queued() {
  const Drops drops = unsent();
  payloads_.clear();
  ends_.clear();
  data_count_ = next_ = 0;
  first_round_ = true;
  lost_part_ = complete_ = acknowledged_ = false;
  return drops;
}

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

namespace {

PoseArrival deliver_part(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                         FrameTracker& frames, const PoseHeader& header, std::vector<std::byte>&& message) {
  const bool newest = delivery == Delivery::newest;
  const uint64_t newest_before = frames.newest_whole();
  const auto outcome = frames.part(header.frame, header.part, header.last);
  if (outcome == FrameTracker::Outcome::repeated) return PoseArrival::repeated;
  if (outcome == FrameTracker::Outcome::whole && newest_before != 0)
    counters.frames_dropped.add(frames.missed(newest_before));
  inbox.observe_pose(peer, message);
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
  inbox.pose_part(peer, std::move(message), header.frame, !newest || outcome == FrameTracker::Outcome::whole);
  return PoseArrival::delivered;
}

void deliver_restored(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                      ReceivedPoses& poses) {
  for (ParityReceiver::Restored& part : poses.parity.take_restored())
    deliver_part(inbox, counters, delivery, peer, poses.frames, {part.frame, part.part, part.is_last},
                 std::move(part.message));
  // Who wants all messages also gets parts of frames older than the newest whole one.
  if (delivery == Delivery::newest) poses.parity.close_up_to(poses.frames.newest_whole());
}

}  // namespace

PoseArrival deliver_pose(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                         ReceivedPoses& poses, std::span<const std::byte> payload) {
  PoseHeader header;
  if (!read_pose_header(payload, header)) {
    counters.reject(Cause::malformed);
    return PoseArrival::delivered;
  }
  const std::span<const std::byte> message = payload.subspan(kPoseHeaderBytes);
  if (header.partial) {
    if (header.frame > poses.frames.newest_whole()) poses.frames.partial();
    inbox.partial_pose(peer, std::vector<std::byte>(message.begin(), message.end()), header.frame);
    return PoseArrival::delivered;
  }
  if (poses.parity.has_part(header.frame, header.part)) return PoseArrival::repeated;
  const PoseArrival arrival = deliver_part(inbox, counters, delivery, peer, poses.frames, header,
                                           std::vector<std::byte>(message.begin(), message.end()));
  if (arrival == PoseArrival::repeated) return arrival;
  poses.parity.add_part(header.frame, header.part, header.last, message);
  deliver_restored(inbox, counters, delivery, peer, poses);
  return arrival;
}

void deliver_parity(Inbox& inbox, LinkCounters& counters, Delivery delivery, PeerId peer,
                    ReceivedPoses& poses, std::span<const std::byte> payload) {
  if (!poses.parity.add_parity(payload)) counters.reject(Cause::malformed);
  deliver_restored(inbox, counters, delivery, peer, poses);
}

}  // namespace fire3dv::transport::udp
