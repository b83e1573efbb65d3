#include "protocol/transport/tcp/tcp_send_queue.h"

#include "protocol/wire/image.h"

namespace fire3dv::transport::tcp {
namespace {

constexpr size_t kMaxQueuedReplyBytes = 4 << 20;
constexpr size_t kMaxReplies = 4096;

}  // namespace

SendQueue::SendQueue(std::shared_ptr<PeerBudget> budget)
    : budget_(std::move(budget)), images_(SIZE_MAX, wire::kMaxImageRequests) {}

// Drops the image of the request, or the oldest one. Its memory is freed without the lock.
bool SendQueue::drop_image(std::optional<uint64_t> request) {
  std::optional<Bytes> dropped;
  const std::lock_guard lock(mutex_);
  if (request) dropped = images_.take(*request);
  if (!request && !images_.empty()) dropped = images_.pop();
  dropped_images_ += dropped.has_value();
  return dropped.has_value();
}

bool SendQueue::add_reply(std::vector<std::byte>&& framed) {
  Result<BudgetCharge> charge = BudgetCharge::take(budget_, Resource::queued_bytes, framed.size());
  while (!charge && drop_image({}))
    charge = BudgetCharge::take(budget_, Resource::queued_bytes, framed.size());
  const std::lock_guard lock(mutex_);
  if (is_closed_) return true;
  if (reply_bytes_ + framed.size() > kMaxQueuedReplyBytes || replies_.size() >= kMaxReplies) return false;
  reply_bytes_ += framed.size();
  // An image in transit may use the whole limit; replies may then exceed it by at most 4 MiB.
  replies_.push_back({std::move(framed), charge ? std::move(*charge) : BudgetCharge()});
  return true;
}

std::optional<BudgetCharge> SendQueue::charge_image(uint64_t request, size_t bytes) {
  if (bytes > budget_->limit(Resource::queued_bytes)) return {};
  bool has_older = true;  // of the request
  while (true) {
    Result<BudgetCharge> charge = BudgetCharge::take(budget_, Resource::queued_bytes, bytes);
    if (charge) return std::move(*charge);
    if (std::exchange(has_older, false) && drop_image(request)) continue;
    if (!drop_image({})) return {};
  }
}

void SendQueue::add_image(uint64_t request, Bytes&& block) {
  block.is_image = true;
  std::vector<Bytes> given_up;  // freed after the lock
  const std::lock_guard lock(mutex_);
  if (is_closed_) return;
  given_up = images_.push(request, std::move(block));
  dropped_images_ += given_up.size();
}

bool SendQueue::take_wake() {
  const std::lock_guard lock(mutex_);
  return std::exchange(needs_wake_, false);
}

size_t SendQueue::take_dropped_images() {
  const std::lock_guard lock(mutex_);
  return std::exchange(dropped_images_, 0);
}

std::optional<SendQueue::Bytes> SendQueue::next() {
  const std::lock_guard lock(mutex_);
  if (!replies_.empty()) {
    Bytes reply = std::move(replies_.front());
    replies_.pop_front();
    reply_bytes_ -= reply.size();
    return reply;
  }
  if (!images_.empty()) return images_.pop();
  needs_wake_ = true;
  return {};
}

void SendQueue::close() {
  std::deque<Bytes> replies;
  std::vector<Bytes> images;
  const std::lock_guard lock(mutex_);
  is_closed_ = true;
  replies.swap(replies_);
  reply_bytes_ = 0;
  while (!images_.empty()) images.push_back(images_.pop());
}

}  // namespace fire3dv::transport::tcp
