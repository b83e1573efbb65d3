#include "protocol/transport/udp_pose_sender.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <cerrno>

#include "protocol/transport/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

// 20,000 poses. More is not kept: the first frame after the session begins does as well.
constexpr size_t kMostKeptBytes = 1 << 20;
constexpr size_t kKeptHeaderBytes = kPoseHeaderBytes + 2;

}  // namespace

PoseSender::Outcome PoseSender::publish(int fd, Session* session, const wire::MessagePieces& message,
                                        bool last_part, uint64_t& overtaken) {
  const bool first_part = part_ == 0;
  if (first_part) ++frame_;
  const bool fits = message.size() <= kMaxPoseBytes && part_ <= UINT16_MAX;
  const PoseHeader header{frame_, static_cast<uint16_t>(part_), last_part};
  part_ = last_part ? 0 : part_ + 1;
  if (first_part) overtaken = drop_kept();
  if (!fits) return Outcome::dropped;
  if (session != nullptr) return send(fd, *session, header, message);
  return keep(header, message) ? Outcome::kept : Outcome::dropped;
}

PoseSender::Outcome PoseSender::send(int fd, Session& session, const PoseHeader& header,
                                     const wire::MessagePieces& message) {
  Session::Buffer head;
  session.start(head, Type::pose);
  write_pose_header(head.data() + kHeaderBytes, header);
  const auto piece = [](std::span<const std::byte> bytes) {
    return iovec{const_cast<std::byte*>(bytes.data()), bytes.size()};
  };
  iovec pieces[3] = {
      {head.data(), kHeaderBytes + kPoseHeaderBytes}, piece(message.head), piece(message.body)};
  msghdr gathered{};
  gathered.msg_iov = pieces;
  gathered.msg_iovlen = 3;
  const ssize_t sent = ::sendmsg(fd, &gathered, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent >= 0) {
    bytes_sent_ += static_cast<uint64_t>(sent);
    return Outcome::sent;
  }
  return errno == ECONNREFUSED ? Outcome::refused : Outcome::dropped;
}

// All memory at once: publish() must not allocate when a renderer goes away in mid-run.
PoseSender::PoseSender() { kept_.reserve(kMostKeptBytes); }

bool PoseSender::keep(const PoseHeader& header, const wire::MessagePieces& message) {
  const size_t at = kept_.size();
  if (at + kKeptHeaderBytes + message.size() > kMostKeptBytes) return false;
  kept_.resize(at + kKeptHeaderBytes);
  write_pose_header(&kept_[at], header);
  put_le<uint16_t>(&kept_[at + kPoseHeaderBytes], static_cast<uint16_t>(message.size()));
  kept_.insert(kept_.end(), message.head.begin(), message.head.end());
  kept_.insert(kept_.end(), message.body.begin(), message.body.end());
  ++kept_messages_;
  return true;
}

uint64_t PoseSender::send_kept(int fd, Session& session) {
  uint64_t lost = 0;
  for (std::span<const std::byte> rest = kept_; !rest.empty();) {
    PoseHeader header;
    read_pose_header(rest, header);
    const size_t bytes = get_le<uint16_t>(rest.data() + kPoseHeaderBytes);
    rest = rest.subspan(kKeptHeaderBytes);
    if (send(fd, session, header, {rest.first(bytes), {}}) != Outcome::sent) ++lost;
    rest = rest.subspan(bytes);
  }
  kept_.clear();
  kept_messages_ = 0;
  return lost;
}

uint64_t PoseSender::drop_kept() {
  kept_.clear();
  return std::exchange(kept_messages_, 0);
}

}  // namespace fire3dv::transport::udp
