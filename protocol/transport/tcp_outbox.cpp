#include "protocol/transport/tcp_outbox.h"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace fire3dv::transport::tcp {
namespace {

constexpr size_t kMostBytesAFlush = 256 << 10;
constexpr size_t kControlPieceBytes = 64 << 10;

void append(std::vector<std::byte>& to, std::span<const std::byte> bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

bool only_full(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR || error == ENOBUFS;
}

}  // namespace

void Outbox::start_connection(Sealer* sealer) {
  sealer_ = sealer;
  bytes_.clear();
  at_ = 0;
  controls_.clear();
  control_bytes_ = 0;
  has_pose_ = !pose_.empty();
}

void Outbox::keep_pose(const FrameHeader& header, const wire::MessagePieces& message) {
  pose_.clear();
  append(pose_, header);
  append(pose_, message.head);
  append(pose_, message.body);
  has_pose_ = true;
  pose_left_ = false;
}

SendOutcome Outbox::pose(int fd, const wire::MessagePieces& message, bool& overtook) {
  const FrameHeader header = write_frame_header(FrameKind::pose, static_cast<uint32_t>(message.size()));
  const size_t total = header.size() + message.size();
  if (pose_.capacity() < total) {  // now, and not in the middle of a run when the socket first fills up
    pose_.reserve(total);
    bytes_.reserve(2 * total);
  }
  overtook = has_pose_ && !pose_left_;
  const bool must_wait = fd < 0 || waits_to_send();
  keep_pose(header, message);
  if (must_wait) return SendOutcome::would_block;
  if (sealer_ != nullptr) return flush(fd);
  const ssize_t sent = ::send(fd, pose_.data(), total, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent == static_cast<ssize_t>(total)) {
    bytes_sent_ += total;
    has_pose_ = false;
    pose_left_ = true;
    return SendOutcome::done;
  }
  if (sent <= 0) return sent == 0 || only_full(errno) ? SendOutcome::would_block : SendOutcome::broken;
  // Partly sent: the rest has to follow, or the stream loses its place.
  bytes_sent_ += static_cast<uint64_t>(sent);
  has_pose_ = false;
  pose_left_ = true;
  bytes_.assign(pose_.begin() + sent, pose_.end());
  at_ = 0;
  return SendOutcome::would_block;
}

bool Outbox::control(SharedBytes message, size_t limit) {
  if (control_bytes_ > limit) return false;
  control_bytes_ += message->size();
  controls_.push_back({std::move(message)});
  return true;
}

void Outbox::sealed(std::span<const std::byte> bytes) {
  append(bytes_, bytes);
}

bool Outbox::drop_pose() {
  pose_.clear();
  return std::exchange(has_pose_, false) && !pose_left_;
}

// The next piece of the control message in front. Copied piece by piece: a description of tens of megabytes
// is never copied at once while the simulator waits for the lock.
bool Outbox::take_from_control() {
  Control& front = controls_.front();
  std::byte piece_bytes[kControlPieceBytes];
  size_t filled = 0;
  if (front.at == 0) {
    const auto header = write_frame_header(FrameKind::control, static_cast<uint32_t>(front.message->size()));
    std::copy(header.begin(), header.end(), piece_bytes);
    filled = header.size();
  }
  const size_t start = front.at == 0 ? 0 : front.at - kFrameHeaderBytes;
  const size_t taken = std::min(front.message->size() - start, kControlPieceBytes - filled);
  std::copy_n(front.message->begin() + static_cast<std::ptrdiff_t>(start), taken, piece_bytes + filled);
  filled += taken;
  front.at = kFrameHeaderBytes + start + taken;
  const std::span<const std::byte> plain(piece_bytes, filled);
  if (sealer_ == nullptr)
    append(bytes_, plain);
  else if (!sealer_->seal(plain, bytes_))
    return false;
  if (start + taken < front.message->size()) return true;
  control_bytes_ -= front.message->size();
  controls_.pop_front();
  return true;
}

// All bytes are sent: what is next?
bool Outbox::refill() {
  bytes_.clear();
  at_ = 0;
  if (!controls_.empty()) return take_from_control();
  has_pose_ = false;
  pose_left_ = true;
  if (sealer_ != nullptr) return sealer_->seal(pose_, bytes_);
  bytes_.assign(pose_.begin(), pose_.end());
  return true;
}

SendOutcome Outbox::flush(int fd) {
  size_t budget = kMostBytesAFlush;
  while (waits_to_send()) {
    if (budget == 0) return SendOutcome::would_block;
    if (at_ == bytes_.size() && !refill()) return SendOutcome::broken;
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
