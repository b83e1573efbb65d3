#include "protocol/transport/inbox.h"

#include <algorithm>
#include <utility>

#include "protocol/transport/clock.h"

namespace fire3dv::transport {

using Kind = LinkEvent::Kind;

namespace {
constexpr size_t kMostControls = 256;
constexpr size_t kMostControlBytes = kMaxMessageBytes + (size_t{16} << 20);
// Empty messages take memory too.
constexpr size_t cost_of(size_t message_bytes) {
  return message_bytes + 128;
}
constexpr size_t kMostStates = 256;
constexpr size_t kMostStateBytes = size_t{64} << 20;
// As many as a simulator publishes between two whole frames at 4 kHz.
constexpr size_t kMostPartials = 1024;
constexpr size_t kMostNotes = 64;  // different texts; more of them are an attack on the log
}  // namespace

void Inbox::push(PeerId peer, Item item, bool wakes) {
  Entry& entry = entries_[peer];
  entry.bytes += cost_of(item.message.size());
  bytes_ += cost_of(item.message.size());
  item.received_ns = monotonic_ns();
  entry.items.push_back(std::move(item));
  if (!wakes) return;
  news_ = true;
  came_.notify_one();
}

void Inbox::connected(PeerId peer) {
  const std::lock_guard lock(mutex_);
  push(peer, {Kind::connected, {}, {}});
}

void Inbox::disconnected(PeerId peer, std::string reason) {
  const std::lock_guard lock(mutex_);
  push(peer, {Kind::disconnected, {}, std::move(reason)});
}

void Inbox::pose(PeerId peer, std::vector<std::byte>&& message, bool replaces_older) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_[peer];
  if (replaces_older) {
    std::erase_if(entry.items, [&](const Item& item) {
      if (item.kind != Kind::pose) return false;
      entry.bytes -= cost_of(item.message.size());
      bytes_ -= cost_of(item.message.size());
      counters_.poses_dropped.add();
      return true;
    });
    entry.partials = 0;
  }
  if (!make_room(message.size())) return;
  push(peer, {Kind::pose, std::move(message), {}});
}

void Inbox::pose_part(PeerId peer, std::vector<std::byte>&& message, uint64_t frame, bool wakes) {
  const std::lock_guard lock(mutex_);
  if (!make_room(message.size())) return;
  push(peer, {Kind::pose, std::move(message), {}, frame}, wakes);
}

void Inbox::drop_parts_before(PeerId peer, uint64_t frame) {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(peer);
  if (entry == entries_.end()) return;
  std::erase_if(entry->second.items, [&](const Item& item) {
    if (item.kind != Kind::pose || item.frame >= frame) return false;
    entry->second.bytes -= cost_of(item.message.size());
    bytes_ -= cost_of(item.message.size());
    counters_.poses_dropped.add();
    if (item.is_partial) --entry->second.partials;
    return true;
  });
}

void Inbox::partial_pose(PeerId peer, std::vector<std::byte>&& message, uint64_t frame) {
  const std::lock_guard lock(mutex_);
  if (entries_[peer].partials == kMostPartials) return counters_.poses_dropped.add();
  if (!make_room(message.size())) return;
  ++entries_[peer].partials;
  push(peer, {Kind::pose, std::move(message), {}, frame, 0, false, true});
}

std::optional<Cause> Inbox::state(PeerId peer, std::vector<std::byte>&& message) {
  const std::lock_guard lock(mutex_);
  if (bytes_ + cost_of(message.size()) > most_bytes_) return Cause::no_memory;
  Entry& entry = entries_[peer];
  ++entry.states;
  entry.state_bytes += message.size();
  push(peer, {Kind::control, std::move(message), {}, 0, 0, true, false});
  return {};
}

bool Inbox::is_full_of_states(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(peer);
  return entry != entries_.end() &&
         (entry->second.states >= kMostStates || entry->second.state_bytes >= kMostStateBytes);
}

std::optional<Cause> Inbox::control(PeerId peer, std::vector<std::byte>&& message) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_[peer];
  if (entry.controls == kMostControls || entry.bytes - entry.state_bytes + message.size() > kMostControlBytes)
    return Cause::unread;
  if (bytes_ + cost_of(message.size()) > most_bytes_) return Cause::no_memory;
  ++entry.controls;
  push(peer, {Kind::control, std::move(message), {}});
  return {};
}

// For a pose: when nobody polls, those that would not fit are what is dropped.
bool Inbox::make_room(size_t bytes) {
  if (bytes_ + cost_of(bytes) <= most_bytes_) return true;
  counters_.poses_dropped.add();
  counters_.reject(Cause::no_memory);
  return false;
}

void Inbox::note_once(const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (noted_.size() == kMostNotes || !noted_.insert(text).second) return;
  notes_.push_back(text);
  news_ = true;
  came_.notify_one();
}

Inbox::Waiting Inbox::waiting(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(peer);
  if (entry == entries_.end()) return {};
  return {entry->second.items.size(), entry->second.bytes};
}

size_t Inbox::entries() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

void Inbox::poll(const std::function<void(const LinkEvent&)>& on_event) {
  std::map<PeerId, Entry> entries;
  std::vector<std::string> notes;
  {
    const std::lock_guard lock(mutex_);
    entries.swap(entries_);
    bytes_ = 0;
    notes.swap(notes_);
    news_ = false;
  }
  for (const std::string& text : notes) on_event({Kind::note, 0, {}, text, 0});
  for (const auto& [peer, entry] : entries) {
    for (const Item& item : entry.items) {
      if (item.kind == Kind::pose || item.kind == Kind::control) counters_.messages_received.add();
      on_event({item.kind, peer, item.message, item.text, item.received_ns});
    }
  }
}

void Inbox::wait(std::chrono::nanoseconds timeout) {
  std::unique_lock lock(mutex_);
  came_.wait_for(lock, std::max(timeout, std::chrono::nanoseconds::zero()), [this] { return news_; });
}

}  // namespace fire3dv::transport
