// Where a listener's own thread leaves what came, for the thread that polls. One entry per peer, in order; in
// Delivery::newest at most one pose of a peer waits. Bounded: whoever sends more than is polled is told to
// stop.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "protocol/transport/link.h"
#include "protocol/transport/link_counters.h"

namespace fire3dv::transport {

class Inbox {
 public:
  Inbox(LinkCounters& counters, size_t most_bytes) : counters_(counters), most_bytes_(most_bytes) {}

  // --- the listener's thread
  void connected(PeerId peer);
  void disconnected(PeerId peer, std::string reason);
  // replaces_older: a pose that supersedes the pose of this peer that still waits.
  void pose(PeerId peer, std::vector<std::byte>&& message, bool replaces_older);
  // A cause when too much of this peer, or of all peers, waits already.
  std::optional<Cause> control(PeerId peer, std::vector<std::byte>&& message);
  // A keyed control message. The listener holds the sender back when many wait, so that a snapshot of any
  // length may come at once.
  std::optional<Cause> state(PeerId peer, std::vector<std::byte>&& message);
  // A pose that builds on those before it: replaces nothing, and is replaced by the next whole one.
  void partial_pose(PeerId peer, std::vector<std::byte>&& message, uint64_t frame);
  // As much keyed state of this peer waits as may.
  bool is_full_of_states(PeerId peer) const;
  // Once for each text.
  void note_once(const std::string& text);
  // Messages of this peer that wait, to hold back a peer whose poses must not be dropped.
  struct Waiting {
    size_t messages = 0;
    size_t bytes = 0;
  };
  Waiting waiting(PeerId peer) const;
  // Peers with events that were not polled yet, alive or not.
  size_t entries() const;
  // wakes: whoever waits is woken for it. Of a frame that is not whole yet there is nothing to be shown, and
  // waking for each part would take the time in which the others come.
  void pose_part(PeerId peer, std::vector<std::byte>&& message, uint64_t frame, bool wakes);
  void drop_parts_before(PeerId peer, uint64_t frame);

  // --- the polling thread
  void poll(const std::function<void(const LinkEvent&)>& on_event);
  void wait(std::chrono::nanoseconds timeout);

 private:
  struct Item {
    LinkEvent::Kind kind;
    std::vector<std::byte> message;
    std::string text;
    uint64_t frame = 0;
    int64_t received_ns = 0;
    bool is_state = false;
    bool is_partial = false;
  };
  struct Entry {
    std::vector<Item> items;
    size_t controls = 0;
    size_t bytes = 0;
    size_t states = 0;
    size_t state_bytes = 0;
    size_t partials = 0;
  };
  void push(PeerId peer, Item item, bool wakes = true);
  bool make_room(size_t bytes);

  LinkCounters& counters_;
  const size_t most_bytes_;  // of all peers together
  size_t bytes_ = 0;
  mutable std::mutex mutex_;
  std::condition_variable came_;
  bool news_ = false;
  std::map<PeerId, Entry> entries_;
  std::vector<std::string> notes_;
  std::set<std::string> noted_;
};

}  // namespace fire3dv::transport
