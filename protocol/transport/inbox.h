// Queue between the thread of a network listener and the thread that polls. It has one entry per peer. In
// Delivery::newest at most one whole pose of a peer waits. Each waiting message is charged to the budget of
// its peer, so that the messages of one peer never take the room of another.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/peer_budget.h"
#include "protocol/transport/link.h"
#include "protocol/transport/link_counters.h"
#include "protocol/transport/note_limiter.h"

namespace fire3dv::transport {

class Inbox {
 public:
  // `name` begins each note: the URI of the listener.
  Inbox(LinkCounters& counters, std::string name) : counters_(counters), name_(std::move(name)) {}

  // --- the listener's thread
  // The messages of the peer are charged to `budget` as Resource::received_bytes until they have been polled.
  void connected(PeerId peer, std::shared_ptr<PeerBudget> budget);
  void disconnected(PeerId peer, std::string reason);
  // replaces_older: drops the poses of this peer that still wait.
  void pose(PeerId peer, std::vector<std::byte>&& message, bool replaces_older);
  // A cause when too many control messages of this peer wait already, or its budget is used up.
  std::optional<Cause> control(PeerId peer, std::vector<std::byte>&& message);
  // A keyed control message. The listener stops reading from the peer when many wait, so that a snapshot of
  // any length may arrive in one burst.
  std::optional<Cause> state(PeerId peer, std::vector<std::byte>&& message);
  // A pose that builds on earlier ones: replaces nothing, and is replaced by the next whole one.
  void partial_pose(PeerId peer, std::vector<std::byte>&& message, uint64_t frame);
  // As much keyed state of this peer waits as may.
  bool is_full_of_states(PeerId peer) const;
  // Passes `text` to the polling thread, within the rate of NoteLimiter. `key` is the text without the remote
  // address.
  void note(std::optional<Cause> cause, const std::string& key, const std::string& text);
  // Messages of this peer that wait, to stop reading from a peer whose poses must not be dropped.
  struct Waiting {
    size_t messages = 0;
    size_t bytes = 0;
  };
  Waiting waiting(PeerId peer) const;
  // Peers that are connected, and those whose end was not polled yet.
  size_t entries() const;
  bool is_accepted(PeerId peer) const;
  // wakes: wakes the polling thread. A frame that is not whole yet cannot be shown, and a wake-up for each
  // part would delay the others.
  void pose_part(PeerId peer, std::vector<std::byte>&& message, uint64_t frame, bool wakes);
  // The cost is proportional to the number of dropped parts.
  void drop_parts_before(PeerId peer, uint64_t frame);

  // --- the polling thread
  void poll(const std::function<void(const LinkEvent&)>& on_event);
  void wait(std::chrono::nanoseconds timeout);
  void accept(PeerId peer);
  void pause(PeerId peer, bool is_paused);

  // --- any thread
  // Null once the end of the peer has been polled.
  std::shared_ptr<PeerBudget> budget(PeerId peer) const;
  // Waiting messages that pose() and drop_parts_before() have looked at, for tests of their cost.
  uint64_t examined_messages() const;

 private:
  struct Item {
    LinkEvent::Kind kind;
    std::vector<std::byte> message;
    std::string text;
    uint64_t order = 0;  // over all items of the inbox
    int64_t received_ns = 0;
    bool is_partial = false;
  };
  using Poses = std::map<uint64_t, std::vector<Item>>;  // by frame; 0 for links that keep the order
  struct Events {
    std::vector<Item> others;  // all but poses, in order
    Poses poses;
    size_t messages = 0;
    size_t bytes = 0;
    size_t controls = 0;
    size_t states = 0;
    size_t state_bytes = 0;
    size_t partials = 0;
    bool is_empty() const { return others.empty() && poses.empty(); }
  };
  struct Entry {
    explicit Entry(std::shared_ptr<PeerBudget> of_peer) : budget(std::move(of_peer)) {}
    ~Entry() { budget->give_back(Resource::received_bytes, charged); }
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;

    const std::shared_ptr<PeerBudget> budget;
    uint64_t charged = 0;  // to the budget, in steps: at least in_use
    uint64_t in_use = 0;   // bytes of messages that wait or are being polled
    Events events;
    bool is_accepted = false;
    bool is_paused = false;
    bool has_ended = false;
  };
  struct Batch {
    PeerId peer;
    Events events;
    bool is_last;
  };
  class Polled;

  Entry* find(PeerId peer);
  const Entry* find(PeerId peer) const;
  void push_event(Entry& entry, Item&& item);
  void push_pose(Entry& entry, uint64_t frame, std::vector<std::byte>&& message, bool is_partial, bool wakes);
  void wake();
  bool charge(Entry& entry, size_t message_bytes);
  Poses take_poses_before(Entry& entry, Poses::iterator end);
  void settle(const Batch& batch);
  void deliver(Batch& batch, const std::function<void(const LinkEvent&)>& on_event);

  LinkCounters& counters_;
  const std::string name_;
  mutable std::mutex mutex_;
  std::condition_variable came_;
  bool has_news_ = false;
  std::map<PeerId, Entry> entries_;
  uint64_t next_order_ = 0;
  uint64_t examined_messages_ = 0;
  NoteLimiter limiter_;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::transport
