#include "protocol/transport/tcp_outbox.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace fire3dv::transport::tcp {
namespace {

constexpr size_t kMostBytesAFlush = 256 << 10;

void append(std::vector<std::byte>& to, std::span<const std::byte> bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

bool only_full(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR || error == ENOBUFS;
}

}  // namespace

void Outbox::start_connection() {
  bytes_.clear();
  at_ = 0;
}

void Outbox::keep_pose(const FrameHeader& header, const wire::MessagePieces& message) {
  pose_.clear();
  append(pose_, header);
  append(pose_, message.head);
  append(pose_, message.body);
  has_pose_ = true;
}

SendOutcome Outbox::pose(int fd, const wire::MessagePieces& message, bool& overtook) {
  const FrameHeader header = write_frame_header(FrameKind::pose, static_cast<uint32_t>(message.size()));
  const size_t total = header.size() + message.size();
  if (pose_.capacity() < total) {  // now, and not in the middle of a run when the socket first fills up
    pose_.reserve(total);
    bytes_.reserve(2 * total);
  }
  overtook = has_pose_;
  if (fd < 0 || waits_to_send()) {
    keep_pose(header, message);
    return SendOutcome::would_block;
  }
  const auto piece = [](std::span<const std::byte> bytes) {
    return iovec{const_cast<std::byte*>(bytes.data()), bytes.size()};
  };
  iovec pieces[3] = {piece(header), piece(message.head), piece(message.body)};
  msghdr gathered{};
  gathered.msg_iov = pieces;
  gathered.msg_iovlen = 3;
  const ssize_t sent = ::sendmsg(fd, &gathered, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent == static_cast<ssize_t>(total)) {
    bytes_sent_ += total;
    return SendOutcome::done;
  }
  if (sent <= 0) {
    keep_pose(header, message);
    return sent == 0 || only_full(errno) ? SendOutcome::would_block : SendOutcome::broken;
  }
  // Partly sent: the rest has to follow, or the stream loses its place.
  bytes_sent_ += static_cast<uint64_t>(sent);
  size_t skip = static_cast<size_t>(sent);
  bytes_.clear();
  at_ = 0;
  for (const std::span<const std::byte> part :
       {std::span<const std::byte>(header), message.head, message.body}) {
    const size_t skipped = std::min(skip, part.size());
    append(bytes_, part.subspan(skipped));
    skip -= skipped;
  }
  return SendOutcome::would_block;
}

bool Outbox::control(std::span<const std::byte> message, size_t limit) {
  if (bytes_.size() - at_ > limit) return false;
  if (at_ > bytes_.size() / 2) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ = 0;
  }
  append(bytes_, write_frame_header(FrameKind::control, static_cast<uint32_t>(message.size())));
  append(bytes_, message);
  return true;
}

bool Outbox::drop_pose() {
  return std::exchange(has_pose_, false);
}

SendOutcome Outbox::flush(int fd) {
  size_t budget = kMostBytesAFlush;
  while (waits_to_send()) {
    if (at_ == bytes_.size()) {
      std::swap(bytes_, pose_);
      at_ = 0;
      has_pose_ = false;
    }
    if (budget == 0) return SendOutcome::would_block;
    const size_t wanted = std::min(bytes_.size() - at_, budget);
    const ssize_t sent = ::send(fd, bytes_.data() + at_, wanted, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) return only_full(errno) ? SendOutcome::would_block : SendOutcome::broken;
    at_ += static_cast<size_t>(sent);
    bytes_sent_ += static_cast<uint64_t>(sent);
    budget -= static_cast<size_t>(sent);
  }
  bytes_.clear();
  at_ = 0;
  return SendOutcome::done;
}

}  // namespace fire3dv::transport::tcp
