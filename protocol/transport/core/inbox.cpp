#include "protocol/transport/core/inbox.h"

#include <algorithm>
#include <utility>

namespace fire3dv::transport {

using Kind = LinkEvent::Kind;

namespace {

constexpr size_t kMaxSeen = 2 * NoteLimiter::kMaxNotesPerWindow;
constexpr size_t kMaxKeyBytes = 256;

constexpr size_t kMaxControls = 256;
constexpr size_t kMaxQueuedControlBytes = kMaxMessageBytes + (size_t{16} << 20);
// Empty messages take memory as well.
constexpr size_t cost_of(size_t message_bytes) {
  return message_bytes + 128;
}
constexpr size_t kMaxQueuedStates = 256;
constexpr size_t kMaxQueuedStateBytes = size_t{64} << 20;
// the number of messages between two whole frames at 4 kHz
constexpr size_t kMaxPartials = 1024;
// Budgets are charged in steps of this size, and a peer retains one step. Small messages thus rarely take the
// pool's lock.
constexpr uint64_t kChargeStep = 64 << 10;
constexpr size_t kMaxWaitingNotes = 256;

}  // namespace

bool NoteLimiter::allow(std::optional<Cause> cause, const std::string& key, int64_t now_ns) {
  Window& window = windows_[cause ? static_cast<size_t>(*cause) : kCauseCount];
  if (now_ns - window.begins_ns >= kWindowNs) {
    window.begins_ns = now_ns;
    window.shown = 0;
    window.unreported += std::exchange(window.suppressed, 0);
    std::erase_if(window.seen, [&](const Occurrence& seen) { return now_ns - seen.at_ns >= kWindowNs; });
  }
  const std::string short_key = key.substr(0, kMaxKeyBytes);
  const auto known = std::find_if(window.seen.begin(), window.seen.end(),
                                  [&](const Occurrence& seen) { return seen.key == short_key; });
  if (known != window.seen.end()) known->at_ns = now_ns;
  if (known != window.seen.end() || window.shown == kMaxNotesPerWindow) {
    ++window.suppressed;
    ++suppressed_;
    return false;
  }
  if (window.seen.size() == kMaxSeen)
    window.seen.erase(
        std::min_element(window.seen.begin(), window.seen.end(),
                         [](const Occurrence& a, const Occurrence& b) { return a.at_ns < b.at_ns; }));
  window.seen.push_back({short_key, now_ns});
  ++window.shown;
  return true;
}

void NoteLimiter::take_summaries(int64_t now_ns, std::vector<std::string>& summaries) {
  if (suppressed_ == 0) return;
  for (size_t i = 0; i < windows_.size(); ++i) {
    Window& window = windows_[i];
    uint64_t count = std::exchange(window.unreported, 0);
    if (now_ns - window.begins_ns >= kWindowNs) count += std::exchange(window.suppressed, 0);
    if (count == 0) continue;
    const std::string cause =
        i < kCauseCount ? std::string(" (") + cause_name(static_cast<Cause>(i)) + ")" : "";
    summaries.push_back("and " + std::to_string(count) + " more were refused" + cause + " in the last 10 s");
    suppressed_ -= count;
  }
}

Inbox::Entry* Inbox::find(PeerId peer) {
  const auto found = entries_.find(peer);
  return found != entries_.end() ? &found->second : nullptr;
}

const Inbox::Entry* Inbox::find(PeerId peer) const {
  const auto found = entries_.find(peer);
  return found != entries_.end() ? &found->second : nullptr;
}

void Inbox::wake() {
  has_events_ = true;
  arrived_.notify_one();
}

void Inbox::push_event(Entry& entry, Item&& item) {
  item.order = ++next_order_;
  item.received_ns = monotonic_ns();
  entry.events.others.push_back(std::move(item));
  ++entry.events.messages;
  wake();
}

// Drops a pose beyond the budget: newer ones follow.
void Inbox::push_pose(Entry& entry, uint64_t frame, std::vector<std::byte>&& message, bool is_partial,
                      bool wakes) {
  if (!charge(entry, message.size())) {
    counters_.poses_dropped.add();
    counters_.reject(Cause::no_memory);
    return;
  }
  entry.events.poses[frame].push_back(
      {Kind::pose, std::move(message), {}, ++next_order_, monotonic_ns(), is_partial});
  ++entry.events.messages;
  entry.events.partials += is_partial;
  if (wakes) wake();
}

bool Inbox::charge(Entry& entry, size_t message_bytes) {
  const uint64_t cost = cost_of(message_bytes);
  if (entry.in_use + cost > entry.charged) {
    const uint64_t missing = entry.in_use + cost - entry.charged;
    uint64_t taken = (missing + kChargeStep - 1) / kChargeStep * kChargeStep;
    if (!entry.budget->try_take(Resource::received_bytes, taken)) {
      taken = missing;
      if (!entry.budget->try_take(Resource::received_bytes, taken)) return false;
    }
    entry.charged += taken;
  }
  entry.in_use += cost;
  entry.events.bytes += cost;
  return true;
}

void Inbox::connected(PeerId peer, std::shared_ptr<PeerBudget> budget) {
  const std::lock_guard lock(mutex_);
  push_event(entries_.try_emplace(peer, std::move(budget)).first->second, {Kind::connected, {}, {}});
}

void Inbox::disconnected(PeerId peer, std::string reason) {
  observe(Kind::disconnected, peer, {});
  const std::lock_guard lock(mutex_);
  Entry* const entry = find(peer);
  if (entry == nullptr) return;
  entry->has_ended = true;
  push_event(*entry, {Kind::disconnected, {}, std::move(reason)});
}

// Removes the poses before `end`; the caller frees them without the lock.
Inbox::Poses Inbox::take_poses_before(Entry& entry, Poses::iterator end) {
  Poses taken;
  Events& events = entry.events;
  while (events.poses.begin() != end) {
    auto node = events.poses.extract(events.poses.begin());
    for (const Item& item : node.mapped()) {
      ++examined_messages_;
      --events.messages;
      events.bytes -= cost_of(item.message.size());
      entry.in_use -= cost_of(item.message.size());
      events.partials -= item.is_partial;
      ++events.overtaken;
      counters_.poses_dropped.add();
    }
    taken.insert(taken.end(), std::move(node));
  }
  return taken;
}

void Inbox::pose(PeerId peer, std::vector<std::byte>&& message, bool replaces_older) {
  observe_pose(peer, message);
  Poses dropped;
  const std::lock_guard lock(mutex_);
  Entry* const entry = find(peer);
  if (entry == nullptr) return;
  if (replaces_older) dropped = take_poses_before(*entry, entry->events.poses.end());
  push_pose(*entry, 0, std::move(message), false, true);
}

void Inbox::pose_part(PeerId peer, std::vector<std::byte>&& message, uint64_t frame, bool wakes) {
  const std::lock_guard lock(mutex_);
  if (Entry* const entry = find(peer)) push_pose(*entry, frame, std::move(message), false, wakes);
}

void Inbox::drop_parts_before(PeerId peer, uint64_t frame) {
  Poses dropped;
  const std::lock_guard lock(mutex_);
  if (Entry* const entry = find(peer))
    dropped = take_poses_before(*entry, entry->events.poses.lower_bound(frame));
}

void Inbox::partial_pose(PeerId peer, std::vector<std::byte>&& message, uint64_t frame) {
  observe_pose(peer, message);
  const std::lock_guard lock(mutex_);
  Entry* const entry = find(peer);
  if (entry == nullptr) return;
  if (entry->events.partials == kMaxPartials) return counters_.poses_dropped.add();
  push_pose(*entry, frame, std::move(message), true, true);
}

std::optional<Cause> Inbox::state(PeerId peer, std::vector<std::byte>&& message) {
  observe(Kind::control, peer, message);
  const std::lock_guard lock(mutex_);
  Entry* const entry = find(peer);
  if (entry == nullptr) return {};
  if (!charge(*entry, message.size())) return Cause::no_memory;
  ++entry->events.states;
  entry->events.state_bytes += message.size();
  push_event(*entry, {Kind::control, std::move(message), {}});
  return {};
}

bool Inbox::is_full_of_states(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const Entry* const entry = find(peer);
  return entry != nullptr &&
         (entry->events.states >= kMaxQueuedStates || entry->events.state_bytes >= kMaxQueuedStateBytes);
}

std::optional<Cause> Inbox::control(PeerId peer, std::vector<std::byte>&& message) {
  observe(Kind::control, peer, message);
  const std::lock_guard lock(mutex_);
  Entry* const entry = find(peer);
  if (entry == nullptr) return {};
  Events& events = entry->events;
  if (events.controls == kMaxControls ||
      events.bytes - events.state_bytes + message.size() > kMaxQueuedControlBytes)
    return Cause::unread;
  if (!charge(*entry, message.size())) return Cause::no_memory;
  ++events.controls;
  push_event(*entry, {Kind::control, std::move(message), {}});
  return {};
}

void Inbox::note(std::optional<Cause> cause, const std::string& key, const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (!limiter_.allow(cause, key, monotonic_ns()) || notes_.size() == kMaxWaitingNotes) return;
  notes_.push_back(name_ + ": " + text);
  wake();
}

Inbox::Waiting Inbox::waiting(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const Entry* const entry = find(peer);
  if (entry == nullptr) return {};
  return {entry->events.messages, entry->events.bytes};
}

size_t Inbox::entries() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

uint64_t Inbox::examined_messages() const {
  const std::lock_guard lock(mutex_);
  return examined_messages_;
}

std::shared_ptr<PeerBudget> Inbox::budget(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const Entry* const entry = find(peer);
  return entry != nullptr ? entry->budget : nullptr;
}

void Inbox::accept(PeerId peer) {
  const std::lock_guard lock(mutex_);
  if (Entry* const entry = find(peer)) entry->is_accepted = true;
}

bool Inbox::is_accepted(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const Entry* const entry = find(peer);
  return entry != nullptr && entry->is_accepted;
}

void Inbox::pause(PeerId peer, bool is_paused) {
  const std::lock_guard lock(mutex_);
  Entry* const entry = find(peer);
  if (entry == nullptr) return;
  entry->is_paused = is_paused;
  if (!is_paused && !entry->events.is_empty()) wake();
}

// Releases the charges of a delivered batch.
void Inbox::settle(const Batch& batch) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(batch.peer);
  if (found == entries_.end()) return;
  if (batch.is_last) {
    entries_.erase(found);
    return;
  }
  Entry& entry = found->second;
  entry.in_use -= batch.events.bytes;
  const uint64_t spare = entry.charged - entry.in_use;
  if (spare <= kChargeStep) return;
  entry.budget->give_back(Resource::received_bytes, spare - kChargeStep);
  entry.charged -= spare - kChargeStep;
}

// Batches of one poll(). Settles undelivered batches as well if a callback throws.
class Inbox::Polled {
 public:
  explicit Polled(Inbox& inbox) : inbox_(inbox) {}
  ~Polled() {
    for (; next_ < batches.size(); ++next_) inbox_.settle(batches[next_]);
  }
  Polled(const Polled&) = delete;
  Polled& operator=(const Polled&) = delete;

  Batch* current() { return next_ < batches.size() ? &batches[next_] : nullptr; }
  void next() {
    inbox_.settle(batches[next_]);
    batches[next_++].events = {};
  }

  std::vector<Batch> batches;

 private:
  Inbox& inbox_;
  size_t next_ = 0;
};

void Inbox::poll(const std::function<void(const LinkEvent&)>& on_event) {
  Polled polled(*this);
  std::vector<std::string> notes, summaries;
  {
    const std::lock_guard lock(mutex_);
    for (auto& [peer, entry] : entries_) {
      if (entry.is_paused || entry.events.is_empty()) continue;
      polled.batches.push_back({peer, std::exchange(entry.events, {}), entry.has_ended});
    }
    notes.swap(notes_);
    if (limiter_.has_suppressed()) limiter_.take_summaries(monotonic_ns(), summaries);
    has_events_ = false;
  }
  for (const std::string& text : notes) on_event({Kind::note, 0, {}, text, 0});
  for (const std::string& text : summaries) on_event({Kind::note, 0, {}, name_ + ": " + text, 0});
  for (; Batch* const batch = polled.current(); polled.next()) deliver(*batch, on_event);
}

// Delivers events in order of arrival.
void Inbox::deliver(Batch& batch, const std::function<void(const LinkEvent&)>& on_event) {
  std::vector<const Item*> poses;
  for (const auto& [frame, items] : batch.events.poses)
    for (const Item& item : items) poses.push_back(&item);
  const auto is_earlier = [](const Item* a, const Item* b) { return a->order < b->order; };
  if (batch.events.poses.size() > 1) std::sort(poses.begin(), poses.end(), is_earlier);
  const auto deliver_one = [&](const Item& item) {
    if (item.kind == Kind::pose || item.kind == Kind::control) counters_.messages_received.add();
    const uint64_t overtaken = item.kind == Kind::pose ? std::exchange(batch.events.overtaken, 0) : 0;
    on_event({item.kind, batch.peer, item.message, item.text, item.received_ns, overtaken});
  };
  auto pose = poses.begin();
  for (const Item& other : batch.events.others) {
    for (; pose != poses.end() && (*pose)->order < other.order; ++pose) deliver_one(**pose);
    deliver_one(other);
  }
  for (; pose != poses.end(); ++pose) deliver_one(**pose);
}

void Inbox::wait(std::chrono::nanoseconds timeout) {
  std::unique_lock lock(mutex_);
  arrived_.wait_for(lock, std::max(timeout, std::chrono::nanoseconds::zero()),
                    [this] { return has_events_; });
}

}  // namespace fire3dv::transport
