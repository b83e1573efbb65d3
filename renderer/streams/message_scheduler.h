// Time slices of the render thread for the messages of peers: one slice per peer and poll. Other messages
// wait for later polls, in order. Single-threaded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"

namespace fire3dv::app {

// Listener index and its peer.
using LinkPeer = std::pair<size_t, transport::PeerId>;

// Clock of a poll, read between messages.
struct PollClock {
  std::function<int64_t()> read_ns;
  int64_t now_ns = 0;  // last reading
  void update() { now_ns = read_ns(); }
};

class MessageScheduler {
 public:
  struct Hooks {
    // Handles a message. Returns true if there is a new pose frame to show.
    std::function<bool(LinkPeer peer, const transport::LinkEvent& event)> handle;
    std::function<std::shared_ptr<PeerBudget>(LinkPeer peer)> budget;
    // Pauses the link of a peer, which applies back pressure to the sender, or continues it.
    std::function<void(LinkPeer peer, bool is_paused)> pause;
    // Newer poses replaced so many waiting ones.
    std::function<void(LinkPeer peer, uint64_t poses)> overtaken;
    // Messages are dropped; called once for each peer.
    std::function<void(LinkPeer peer, const std::string& reason)> dropped;
  };
  // Borrows the clock. lockstep: no time slices, and no message is dropped.
  MessageScheduler(bool lockstep, PollClock& clock, std::shared_ptr<const BudgetPool> budgets, Hooks hooks);

  uint64_t begin_poll() { return ++polls_; }
  // Handles an arrived message, or lets it wait. Returns true if there is a new pose frame to show.
  bool receive(LinkPeer peer, const transport::LinkEvent& event);
  // Handles waiting messages, one time slice per peer. Each poll begins with another peer.
  bool handle_deferred();
  // Lockstep: handles messages in order of arrival, until there is a frame to show.
  bool handle_in_order();
  void pause_deferred_peers();
  bool has_ready() const;
  size_t deferred_messages() const;

  // Lets the message that is being handled wait: it is the peer's first one again.
  void put_back(LinkPeer peer, const transport::LinkEvent& event);
  // No message of the peer is handled while it is held.
  void hold(LinkPeer peer, bool is_held) { entries_[peer].is_held = is_held; }
  // The peer's description waits until then; its link is read on, so that its end is seen.
  void await_stream(LinkPeer peer, int64_t until_ns);
  void end_wait(LinkPeer peer) { entries_[peer].is_awaiting_stream = false; }
  // Charges time to a peer as that of control messages: long ones throttle it, for the benefit of others.
  void add_control_time(LinkPeer peer, int64_t ns);
  void remove(LinkPeer peer) { entries_.erase(peer); }

 private:
  // Message that waits for a later poll.
  struct Deferred {
    uint64_t number = 0;  // order of arrival over all peers
    transport::LinkEvent::Kind kind{};
    wire::Bytes message;
    std::string text;
    int64_t received_ns = 0;
    bool is_dropped = false;  // replaced by a newer pose
    size_t bytes() const;
  };
  struct Entry {
    std::deque<Deferred> deferred;
    std::vector<uint64_t> deferred_poses;  // numbers
    BudgetCharge charge;                   // for `deferred`
    uint64_t poll = 0;                     // poll that spent_ns refers to
    int64_t spent_ns = 0;
    int64_t control_ns = 0;          // of control messages and their scene edits, until the next throttling
    int64_t throttled_until_ns = 0;  // no message is handled before
    bool is_held = false;
    bool is_awaiting_stream = false;
    bool is_paused = false;  // its link stores further messages
    bool has_reported_drop = false;
  };

  bool is_ready(const Entry& entry) const {
    return !entry.deferred.empty() && !entry.is_held &&
           (lockstep_ || clock_.now_ns >= entry.throttled_until_ns);
  }
  bool has_time(Entry& entry) const;
  void add_control_time(Entry& entry, int64_t ns);
  bool handle_timed(LinkPeer peer, Entry& entry, const transport::LinkEvent& event);
  bool handle_next(LinkPeer peer);
  void store(LinkPeer peer, Entry& entry, const transport::LinkEvent& event);
  static void release(Entry& entry, size_t bytes);
  void drop_deferred_poses(LinkPeer peer, Entry& entry);
  bool is_whole_frame(std::span<const std::byte> message);

  const bool lockstep_;
  PollClock& clock_;
  const std::shared_ptr<const BudgetPool> budgets_;
  const Hooks hooks_;
  wire::Decoder decoder_;
  std::map<LinkPeer, Entry> entries_;
  std::vector<LinkPeer> turns_;  // scratch memory of handle_deferred()
  LinkPeer last_turn_{};
  uint64_t polls_ = 0, last_number_ = 0;
};

}  // namespace fire3dv::app
