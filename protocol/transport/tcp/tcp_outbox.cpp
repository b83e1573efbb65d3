#include "protocol/transport/tcp/tcp_outbox.h"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace fire3dv::transport::tcp {
namespace {

constexpr size_t kMaxFlushBytes = 256 << 10;
constexpr size_t kControlPieceBytes = 64 << 10;

void append(std::vector<std::byte>& to, std::span<const std::byte> bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

bool only_full(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR || error == ENOBUFS;
}

iovec piece(std::span<const std::byte> bytes) {
  return {const_cast<std::byte*>(bytes.data()), bytes.size()};
}

}  // namespace

void Outbox::start_connection(Sealer* sealer) {
  sealer_ = sealer;
  bytes_.clear();
  at_ = 0;
  controls_.clear();
  control_bytes_ = 0;
  has_pose_ = !pose_.empty();
  has_base_ = snapshot_begun_ = false;
  batches_.start_connection();
}

void Outbox::start_description() {
  states_ = states_.cleared();
  batches_.discard(states_);
  has_base_ = snapshot_begun_ = false;
}

void Outbox::store_pose(const FrameHeader& header, const wire::MessagePieces& message) {
  pose_.clear();
  append(pose_, header);
  append(pose_, message.head);
  append(pose_, message.body);
  has_pose_ = true;
  pose_was_sent_ = false;
}

void Outbox::mark_pose_sent() {
  has_pose_ = false;
  pose_was_sent_ = has_base_ = true;
}

SendOutcome Outbox::pose(int fd, const wire::MessagePieces& message, bool& overtook) {
  return send_pose(fd, FrameKind::pose, message, message, overtook);
}

SendOutcome Outbox::partial_pose(int fd, const wire::MessagePieces& partial, const wire::MessagePieces& whole,
                                 bool& overtook) {
  if (!has_base_) return send_pose(fd, FrameKind::pose, whole, whole, overtook);
  return send_pose(fd, FrameKind::partial_pose, partial, whole, overtook);
}

// Sends `message`, or queues `whole` if the pose must wait.
SendOutcome Outbox::send_pose(int fd, FrameKind kind, const wire::MessagePieces& message,
                              const wire::MessagePieces& whole, bool& overtook) {
  const auto framed = [](FrameKind of, const wire::MessagePieces& what) {
    return write_frame_header(of, static_cast<uint32_t>(what.size()));
  };
  const FrameHeader header = framed(kind, message);
  const size_t total = header.size() + message.size();
  if (const size_t max_bytes = header.size() + whole.size();
      pose_.capacity() < max_bytes) {  // allocates early, not when the socket first fills up
    pose_.reserve(max_bytes);
    bytes_.reserve(2 * max_bytes);
  }
  overtook = has_pose_ && !pose_was_sent_;
  const bool must_wait = fd < 0 || waits_to_send();
  store_pose(framed(FrameKind::pose, whole), whole);
  if (must_wait) return SendOutcome::would_block;
  if (sealer_ != nullptr) {
    framed_.clear();
    append(framed_, header);
    append(framed_, message.head);
    append(framed_, message.body);
    bytes_.clear();
    at_ = 0;
    if (!sealer_->seal(framed_, bytes_)) return SendOutcome::broken;
    mark_pose_sent();
    return flush(fd);
  }
  iovec pieces[3] = {piece(header), piece(message.head), piece(message.body)};
  msghdr gathered{};
  gathered.msg_iov = pieces;
  gathered.msg_iovlen = 3;
  const ssize_t sent = ::sendmsg(fd, &gathered, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent <= 0) return sent == 0 || only_full(errno) ? SendOutcome::would_block : SendOutcome::broken;
  mark_pose_sent();
  if (sent == static_cast<ssize_t>(total)) {
    bytes_sent_ += total;
    return SendOutcome::done;
  }
  // Partially sent: the rest must follow to preserve the framing.
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
  return std::exchange(has_pose_, false) && !pose_was_sent_;
}

// Queues the next piece of the first control message. A description of tens of megabytes is copied in pieces,
// since the simulator may wait for the lock.
bool Outbox::take_from_control() {
  Control& front = controls_.front();
  std::byte piece_bytes[kControlPieceBytes];
  size_t filled = 0;
  if (front.at == 0) {
    const auto header = write_frame_header(front.kind, static_cast<uint32_t>(front.message->size()));
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
  if (front.kind == FrameKind::control) control_bytes_ -= front.message->size();
  controls_.pop_front();
  return true;
}

// Queues the next message after all bytes are sent. A pose goes between two batches of states, so that
// neither starves the other.
bool Outbox::refill() {
  bytes_.clear();
  at_ = 0;
  if (controls_.empty() && (batches_.in_batch() || !has_pose_ || !snapshot_begun_)) {
    snapshot_begun_ = true;
    if (const KeyedState* state = batches_.next(states_)) {
      controls_.push_back({state->message, FrameKind::state});
      batches_.pop();
    }
  }
  if (!controls_.empty()) return take_from_control();
  if (!has_pose_) return true;
  mark_pose_sent();
  if (sealer_ != nullptr) return sealer_->seal(pose_, bytes_);
  bytes_.assign(pose_.begin(), pose_.end());
  return true;
}

SendOutcome Outbox::flush(int fd) {
  size_t budget = kMaxFlushBytes;
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
