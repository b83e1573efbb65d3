#include "protocol/transport/core/network_link.h"

#include "protocol/transport/core/absence.h"

namespace fire3dv::transport {
namespace {

constexpr int64_t kFirstBackoffNs = 10 * kMillisecondNs;
constexpr int64_t kLongestBackoffNs = kSecondNs;
constexpr size_t kMaxUnreadReplies = 1024;
constexpr size_t kMaxUnreadBytes = 64 << 20;

}  // namespace

SharedBytes share(std::span<const std::byte> bytes) {
  return std::make_shared<const wire::Bytes>(bytes.begin(), bytes.end());
}

Error NetworkPublisher::inherited_error() const {
  return Error{uri_text(uri_) + ": the link was opened before fork(); open one in the child"};
}

Result<void> NetworkPublisher::start() {
  return thread_.start(uri_text(uri_), [this] { run(); });
}

void NetworkPublisher::run() {
  int64_t backoff_ns = kFirstBackoffNs;
  while (!thread_.stopping()) {
    bool served = false;
    try {
      const Lookup lookup(uri_);
      while (!lookup.done() && !thread_.stopping()) thread_.wait(-1, 0, kMillisecondNs);
      if (thread_.stopping()) return;
      for (const Address& address : lookup.addresses())
        if (!served && !thread_.stopping()) served = visit(address);
      if (!lookup.problem().empty()) set_problem(uri_text(uri_) + ": " + lookup.problem());
    } catch (const std::exception&) {  // out of memory: retry later, as after any other failure
    }
    if (served) backoff_ns = kFirstBackoffNs;  // reset: the listener may only be restarting
    thread_.pause(backoff_ns);
    backoff_ns = std::min(backoff_ns * 2, kLongestBackoffNs);
  }
}

bool NetworkPublisher::poll(std::vector<std::byte>& message) {
  if (is_inherited()) return false;
  const std::lock_guard lock(mutex_);
  if (replies_.empty()) return false;
  message.swap(replies_.front());
  reply_bytes_ -= message.size();
  replies_.pop_front();
  return true;
}

std::string NetworkPublisher::problem() const {
  if (is_inherited()) return inherited_error().message;
  const std::lock_guard lock(mutex_);
  return problem_;
}

std::string NetworkPublisher::absence() const {
  if (is_inherited()) return {};
  const std::lock_guard lock(mutex_);
  return absence_;
}

void NetworkPublisher::set_absence(std::string reason) {
  const std::lock_guard lock(mutex_);
  absence_ = std::move(reason);
}

std::string absence_of(const PublisherLink& link) {
  const auto* const network = dynamic_cast<const NetworkPublisher*>(&link);
  return network ? network->absence() : std::string();
}

void NetworkPublisher::set_problem(std::string problem) {
  const std::lock_guard lock(mutex_);
  problem_ = std::move(problem);
}

void NetworkPublisher::queue_reply(std::vector<std::byte>&& message) {
  counters_.messages_received.add();
  reply_bytes_ += message.size();
  replies_.push_back(std::move(message));
  // Limits the memory of a simulator that never polls.
  while (replies_.size() > kMaxUnreadReplies || (reply_bytes_ > kMaxUnreadBytes && replies_.size() > 1)) {
    reply_bytes_ -= replies_.front().size();
    replies_.pop_front();
    counters_.reject(Cause::unread);
  }
}

}  // namespace fire3dv::transport
