// What the publishers of TCP and UDP have in common: the search for the listener, the description, and the
// replies that nobody has read yet.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "protocol/transport/address.h"
#include "protocol/transport/fork_guard.h"
#include "protocol/transport/link.h"
#include "protocol/transport/link_counters.h"
#include "protocol/transport/link_thread.h"

namespace fire3dv::transport {

SharedBytes share(std::span<const std::byte> bytes);

class NetworkPublisher : public PublisherLink {
 public:
  Result<void> start();
  bool poll(std::vector<std::byte>& message) final;
  std::string problem() const final;

 protected:
  explicit NetworkPublisher(Uri uri) : uri_(std::move(uri)) {}

  // One address of the listener, on the link's thread: connects, serves until the connection is lost or the
  // link is closed. False when nobody answered there.
  virtual bool visit(const Address& address) = 0;

  // Why nobody is reached, for people; empty when somebody is.
  void set_problem(std::string problem);

  // With the lock held.
  void set_problem_locked(std::string problem) { problem_ = std::move(problem); }
  // Replies that nobody reads are bounded, in number and in bytes: the oldest go.
  void keep_reply(std::vector<std::byte>&& message);

  // True in a child that was forked without exec. The link's thread does not exist there, mutex_ may be
  // locked for ever, and the socket, the keys and the counters are the parent's.
  bool is_inherited() const { return forked_from_ != fork_generation(); }
  Error inherited_error() const;

  const Uri uri_;
  LinkCounters counters_;
  LinkThread thread_;
  mutable std::mutex mutex_;  // guards the replies, and in derived links what they say

 private:
  void run();

  const unsigned forked_from_ = fork_generation();

  std::deque<std::vector<std::byte>> replies_;
  size_t reply_bytes_ = 0;  // of them together
  std::string problem_;
};

}  // namespace fire3dv::transport
