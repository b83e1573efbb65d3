#include "protocol/transport/udp/udp_pose_sender.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

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
  if (session == nullptr || next_ + 1 < ends_.size()) return Outcome::queued;
  const Outcome outcome = send(fd, *session, next_);
  if (outcome == Outcome::sent) {
    ++next_;
    has_base_ = has_base_ || (complete_ && !lost_part_);
  } else {
    repeat_at_ns_ = now_ns + kBurstEveryNs;
  }
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
    outcome = send_bytes(fd, *session, {payload, kPoseHeaderBytes + partial.size()});
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
    emit_due(fd, *session, now_ns);
    if (next_ == ends_.size()) outcome = Outcome::sent;
  }
  return outcome;
}

// A datagram that the socket rejects stays queued.
PoseSender::Outcome PoseSender::send(int fd, Session& session, size_t index) {
  const size_t start = index == 0 ? 0 : ends_[index - 1];
  return send_bytes(fd, session, {payloads_.data() + start, ends_[index] - start});
}

PoseSender::Outcome PoseSender::send_bytes(int fd, Session& session, std::span<const std::byte> payload) {
  Session::Buffer datagram;
  session.start(datagram, Type::pose);
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
  return true;
}

void PoseSender::emit_due(int fd, Session& session, int64_t now_ns) {
  if (acknowledged_ || ends_.empty()) return;
  if (next_ == ends_.size()) {
    if (!complete_ || now_ns < repeat_at_ns_) return;
    next_ = 0;
    first_round_ = false;
  }
  const size_t end = std::min(ends_.size(), next_ + kBurst);
  while (next_ < end && send(fd, session, next_) == Outcome::sent) ++next_;
  repeat_at_ns_ = now_ns + (next_ < ends_.size() ? kBurstEveryNs : repeat_after_ns_);
  has_base_ = has_base_ || (next_ == ends_.size() && complete_);
  if (next_ == ends_.size()) repeat_after_ns_ = std::min(2 * repeat_after_ns_, kLastRepeatNs);
}

std::optional<int64_t> PoseSender::due_at_ns() const {
  if (acknowledged_ || ends_.empty() || (next_ == ends_.size() && !complete_)) return {};
  return repeat_at_ns_;
}

void PoseSender::acknowledge(uint64_t frame) {
  if (frame == frame_ && complete_) acknowledged_ = true;
}

void PoseSender::start_session() {
  if (next_ == ends_.size()) first_round_ = false;
  acknowledged_ = has_base_ = false;
  next_ = 0;
  repeat_at_ns_ = 0;
  repeat_after_ns_ = kFirstRepeatNs;
}

PoseSender::Drops PoseSender::unsent() const {
  if (!first_round_ || acknowledged_) return {};
  const uint64_t messages = ends_.size() - next_;
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
  next_ = 0;
  first_round_ = true;
  lost_part_ = complete_ = acknowledged_ = false;
  return drops;
}

}  // namespace fire3dv::transport::udp
