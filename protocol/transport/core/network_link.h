// Base classes of the links over TCP and UDP: publisher and listener.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/core/fork_guard.h"
#include "protocol/transport/core/inbox.h"
#include "protocol/transport/core/link_counters.h"
#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport {

SharedBytes share(std::span<const std::byte> bytes);

// Base class of the publishers: connection to the listener with retries, description, and the queue of unread
// replies.
class NetworkPublisher : public PublisherLink {
 public:
  Result<void> start();
  bool poll(std::vector<std::byte>& message) final;
  std::string problem() const final;
  std::string absence() const;  // see absence.h

 protected:
  explicit NetworkPublisher(Uri uri) : uri_(std::move(uri)) {}

  // Connects to one address on the link's thread and serves until the connection is lost or the link is
  // closed. Returns false if no listener answered.
  virtual bool visit(const Address& address) = 0;

  // Sets the reason why no listener is connected; empty when one is.
  void set_problem(std::string problem);

  // Sets why no address answers; empty when one does.
  void set_absence(std::string reason);

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
  std::string problem_, absence_;
};

// Base class of the listeners: receive thread, inbox, and one budget per peer.
class NetworkListener : public ListenerLink {
 public:
  void poll(const std::function<void(const LinkEvent&)>& on_event) override { inbox_.poll(on_event); }
  void wait(std::chrono::nanoseconds timeout) final { inbox_.wait(timeout); }
  void accept(PeerId peer) final { inbox_.accept(peer); }
  void pause_peer(PeerId peer, bool is_paused) final { inbox_.pause(peer, is_paused); }
  std::shared_ptr<PeerBudget> budget(PeerId peer) const final { return inbox_.budget(peer); }
  LinkStats stats() const final { return counters_.snapshot(); }
  std::string uri() const final { return uri_; }

 protected:
  NetworkListener(std::string uri, ListenerOptions options)
      : uri_(std::move(uri)),
        options_(std::move(options)),
        pool_(options_.budgets ? options_.budgets : BudgetPool::create()),
        inbox_(counters_, uri_, options_.on_arrival) {}

  // True if the peer limit is reached. Disconnected peers count until their end is polled; otherwise a caller
  // that does not poll would accumulate them.
  bool is_full(size_t peers) const {
    return peers >= options_.max_peers || inbox_.entries() >= size_t{2} * options_.max_peers;
  }
  // Eviction times of unaccepted peers when the listener is full: after the first time without any message,
  // after the second in any case. Connections are otherwise free for an attacker.
  static constexpr int64_t kSilentPeerNs = 5 * kSecondNs;
  static constexpr int64_t kUndescribedPeerNs = 30 * kSecondNs;
  static constexpr const char* kEvictionReason = "it has not described itself, and its slot was needed";
  bool may_evict(PeerId peer, int64_t connected_at_ns, int64_t last_received_ns, int64_t now_ns) const {
    return (now_ns - last_received_ns > kSilentPeerNs || now_ns - connected_at_ns > kUndescribedPeerNs) &&
           !inbox_.is_accepted(peer);
  }

  // Announces a peer to the polling thread and creates its budget.
  std::shared_ptr<PeerBudget> connected(PeerId peer, const std::string& remote) {
    std::shared_ptr<PeerBudget> budget = pool_->add_peer(uri_ + " from " + remote);
    inbox_.connected(peer, budget);
    return budget;
  }
  // Charges the memory of a peer's incomplete messages, in steps, so that most datagrams cost nothing.
  static Result<void> charge_in_steps(BudgetCharge& charge, const std::shared_ptr<PeerBudget>& budget,
                                      size_t buffered_bytes) {
    constexpr size_t kStep = 64 << 10;
    const size_t bytes = buffered_bytes / kStep * kStep;
    if (bytes == charge.amount()) return {};
    if (charge.amount() != 0) return charge.resize(bytes);
    Result<BudgetCharge> taken = BudgetCharge::take(budget, Resource::received_bytes, bytes);
    if (!taken) return taken.error();
    charge = std::move(*taken);
    return {};
  }
  // Same for memory that a peer can do without: it is freed if it exceeds the budget.
  template <typename Memory>
  static void charge_or_clear(BudgetCharge& charge, const std::shared_ptr<PeerBudget>& budget,
                              Memory& memory) {
    if (charge_in_steps(charge, budget, memory.memory_bytes())) return;
    memory.clear();
    charge.release();
  }
  // Reason for disconnecting a peer whose message the inbox refused.
  std::string refusal_text(PeerId peer, Cause cause) const {
    if (cause == Cause::unread) return "it sent more control messages than were read";
    const std::shared_ptr<PeerBudget> budget = inbox_.budget(peer);
    const uint64_t used = budget ? budget->used(Resource::received_bytes) : 0;
    const uint64_t limit = pool_->limits().of(Resource::received_bytes);
    return "its messages that were not read yet use " + amount_text(Resource::received_bytes, used) +
           ", and a further one does not fit; the limit of one peer is " +
           amount_text(Resource::received_bytes, limit) +
           " (the renderer's option --peer-limit received-bytes=VALUE changes it)";
  }

  void reject(Cause cause, const std::string& what) {
    counters_.reject(cause);
    inbox_.note(cause, what, what);
  }

  const std::string uri_;
  const ListenerOptions options_;
  const std::shared_ptr<BudgetPool> pool_;
  LinkCounters counters_;
  Inbox inbox_;
  LinkThread thread_;
  PeerId last_id_ = 0;  // used on the listener's thread only
};

}  // namespace fire3dv::transport
