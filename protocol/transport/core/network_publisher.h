// Base class of the TCP and UDP publishers: connection to the listener with retries, description, and the
// queue of unread replies.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/fork_guard.h"
#include "protocol/transport/core/link_counters.h"
#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/link.h"

namespace fire3dv::transport {

SharedBytes share(std::span<const std::byte> bytes);

class NetworkPublisher : public PublisherLink {
 public:
  Result<void> start();
  bool poll(std::vector<std::byte>& message) final;
  std::string problem() const final;

 protected:
  explicit NetworkPublisher(Uri uri) : uri_(std::move(uri)) {}

  // Connects to one address on the link's thread and serves until the connection is lost or the link is
  // closed. Returns false if no listener answered.
  virtual bool visit(const Address& address) = 0;

  // Sets the reason why no listener is connected; empty when one is.
  void set_problem(std::string problem);

  // Requires mutex_.
  void set_problem_locked(std::string problem) { problem_ = std::move(problem); }
  // Queues a reply. The queue is bounded by number and bytes: the oldest replies are dropped.
  void queue_reply(std::vector<std::byte>&& message);

  // True in a child forked without exec(). There the link's thread does not exist, mutex_ may be locked
  // forever, and socket, keys and counters belong to the parent.
  bool is_inherited() const { return forked_from_ != fork_generation(); }
  Error inherited_error() const;

  const Uri uri_;
  LinkCounters counters_;
  LinkThread thread_;
  mutable std::mutex mutex_;  // guards the replies, and the state that derived links document

 private:
  void run();

  const unsigned forked_from_ = fork_generation();

  std::deque<std::vector<std::byte>> replies_;
  size_t reply_bytes_ = 0;  // total
  std::string problem_;
};

}  // namespace fire3dv::transport
