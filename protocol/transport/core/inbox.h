// Message queue between a network listener's thread and the polling thread, with one entry per peer, and the
// limiter of its notes. With
// Delivery::newest at most one whole pose of a peer is queued. Queued messages are charged to their peer's
// budget, so that peers do not compete for memory.
#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/peer_budget.h"
#include "protocol/transport/core/link_counters.h"
#include "protocol/transport/link.h"

namespace fire3dv::transport {

// Rate limiter of user notes about rejected peers. Passes 8 distinct notes per cause in 10 s and counts the
// others for a summary. Bounded memory. Not thread-safe.
class NoteLimiter {
 public:
  static constexpr size_t kMaxNotesPerWindow = 8;
  static constexpr int64_t kWindowNs = 10 * kSecondNs;

  // Returns true if the note is to be shown. `key` is its text without variable parts such as the remote
  // address. A note repeated within the window is only counted.
  bool allow(std::optional<Cause> cause, const std::string& key, int64_t now_ns);

  // True if suppressed notes await a summary.
  bool has_suppressed() const { return suppressed_ != 0; }
  // Appends "and N more were refused (CAUSE) in the last 10 s" for each cause whose window has ended.
  void take_summaries(int64_t now_ns, std::vector<std::string>& summaries);

 private:
  struct Occurrence {
    std::string key;
    int64_t at_ns;
  };
  struct Window {
    int64_t begins_ns = 0;
    size_t shown = 0;
    uint64_t suppressed = 0;
    uint64_t unreported = 0;  // suppressed in earlier windows
    std::vector<Occurrence> seen;
  };
  std::array<Window, kCauseCount + 1> windows_;  // by cause; the last one is for notes without a cause
  uint64_t suppressed_ = 0;                      // sum over all windows
};

class Inbox {
 public:
  // `name` prefixes each note: the URI of the listener.
  Inbox(LinkCounters& counters, std::string name, OnArrival on_arrival = {})
      : counters_(counters), name_(std::move(name)), on_arrival_(std::move(on_arrival)) {}

  // --- the listener's thread
  // Charges the peer's messages to `budget` as Resource::received_bytes until they are polled.
  void connected(PeerId peer, std::shared_ptr<PeerBudget> budget);
  void disconnected(PeerId peer, std::string reason);
  // replaces_older: drops the queued poses of this peer.
  void pose(PeerId peer, std::vector<std::byte>&& message, bool replaces_older);
  // Returns a cause if too many control messages of this peer are queued, or its budget is exhausted.
  std::optional<Cause> control(PeerId peer, std::vector<std::byte>&& message);
  // Queues a keyed control message. The listener stops reading from a peer with many queued messages, so that
  // a snapshot of any length may arrive in one burst.
  std::optional<Cause> state(PeerId peer, std::vector<std::byte>&& message);
  // Queues a pose that builds on earlier ones: replaces none, and the next whole pose replaces it.
  void partial_pose(PeerId peer, std::vector<std::byte>&& message, uint64_t frame);
  // True if the queued keyed states of this peer have reached their limit.
  bool is_full_of_states(PeerId peer) const;
  // Passes `text` to the polling thread, rate-limited by NoteLimiter. `key` is the text without the remote
  // address.
  void note(std::optional<Cause> cause, const std::string& key, const std::string& text);
  // Queue length of this peer: the listener stops reading if poses must not be dropped.
  struct Waiting {
    size_t messages = 0;
    size_t bytes = 0;
  };
  Waiting waiting(PeerId peer) const;
  // Number of connected peers, and of disconnected peers whose end is not polled yet.
  size_t entries() const;
  bool is_accepted(PeerId peer) const;
  // Passes a pose message to the observer of arrivals. pose() and partial_pose() do so by themselves.
  void observe_pose(PeerId peer, std::span<const std::byte> message) const {
    observe(LinkEvent::Kind::pose, peer, message);
  }
  // wakes: wakes the polling thread. An incomplete frame cannot be shown, and a wake-up per part would delay
  // the others.
  void pose_part(PeerId peer, std::vector<std::byte>&& message, uint64_t frame, bool wakes);
  // Cost: proportional to the number of dropped parts.
  void drop_parts_before(PeerId peer, uint64_t frame);

  // --- the polling thread
  void poll(const std::function<void(const LinkEvent&)>& on_event);
  void wait(std::chrono::nanoseconds timeout);
  void accept(PeerId peer);
  void pause(PeerId peer, bool is_paused);

  // --- any thread
  // Null after the peer's disconnection has been polled.
  std::shared_ptr<PeerBudget> budget(PeerId peer) const;
  // Number of queued messages that pose() and drop_parts_before() have visited, for complexity tests.
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
  using Poses = std::map<uint64_t, std::vector<Item>>;  // by frame; 0 for ordered links
  struct Events {
    std::vector<Item> others;  // all but poses, in order
    Poses poses;
    size_t messages = 0;
    size_t bytes = 0;
    size_t controls = 0;
    size_t states = 0;
    size_t state_bytes = 0;
    size_t partials = 0;
    uint64_t overtaken = 0;  // poses that newer ones replaced
    bool is_empty() const { return others.empty() && poses.empty(); }
  };
  struct Entry {
    explicit Entry(std::shared_ptr<PeerBudget> of_peer) : budget(std::move(of_peer)) {}
    ~Entry() { budget->give_back(Resource::received_bytes, charged); }
    Entry(const Entry&) = delete;
    Entry& operator=(const Entry&) = delete;

    const std::shared_ptr<PeerBudget> budget;
    uint64_t charged = 0;  // charged to the budget, in steps; at least in_use
    uint64_t in_use = 0;   // bytes of messages queued or being polled
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

  void observe(LinkEvent::Kind kind, PeerId peer, std::span<const std::byte> message) const {
    if (on_arrival_) on_arrival_({kind, peer, message, {}, monotonic_ns()});
  }
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
  const OnArrival on_arrival_;
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  bool has_events_ = false;
  std::map<PeerId, Entry> entries_;
  uint64_t next_order_ = 0;
  uint64_t examined_messages_ = 0;
  NoteLimiter limiter_;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::transport
