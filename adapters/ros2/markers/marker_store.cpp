#include "adapters/ros2/markers/marker_store.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kPatienceNs = 3 * kSecondNs;
constexpr int64_t kLookPeriodNs = 100 * kMillisecondNs;  // between looks for frames of held markers
constexpr int64_t kFollowPeriodNs =
    kSecondNs / 30;                     // between updates of locked markers, which are sent whole
constexpr size_t kMaxFrameBytes = 255;  // as the transforms' frames

std::string kind_of(const std::string& topic) {
  return "markers of /" + topic;
}

void warn(const MarkerContext& context, const std::string& topic, const std::string& name,
          const std::string& reason) {
  const std::string what = name == topic ? "the message" : "marker " + quote(name);
  context.warn(kind_of(topic), "/" + topic + ": " + what + " is not shown: " + reason);
}

size_t bytes_of(const ShownMarker& marker) {
  constexpr size_t kOverheadBytes = 512;  // strings and lists of the store
  return kOverheadBytes + marker.name.size() + marker.frame.size() +
         sizeof(float) * (marker.positions.size() + marker.sizes.size()) + marker.colors.size() +
         (marker.texts.empty() ? 0 : marker.texts[0].size());
}

}  // namespace

size_t MarkerStore::size(const std::string& topic) const {
  const auto found = topics_.find(topic);
  return found == topics_.end() ? 0 : found->second.size();
}

void MarkerStore::update(const MarkerContext& context) {
  clear_expired(context);
  const bool is_changed = context.fixed_frame != fixed_frame_;
  const bool has_first_time = context.sim_time_ns && !sim_time_ns_;
  sim_time_ns_ = context.sim_time_ns;
  if (is_changed) change_fixed_frame(context);
  if (!locked_.empty() && (is_changed || context.now_ns >= next_follow_ns_)) {
    next_follow_ns_ = context.now_ns + kFollowPeriodNs;
    follow_frames(context);
  }
  if (held_.empty() || (!is_changed && !has_first_time && context.now_ns < next_look_ns_)) return;
  next_look_ns_ = context.now_ns + kLookPeriodNs;
  show_held(context);
  report_missing_frames(context);
}

void MarkerStore::set(const std::string& topic, ShownMarker marker, const MarkerContext& context) {
  Entries& entries = topics_[topic];
  const auto found = entries.find(marker.name);
  if (found == entries.end() && entries.size() >= limits_.markers_per_topic)
    return warn(context, topic, marker.name,
                "the topic has " + std::to_string(limits_.markers_per_topic) + " markers already");
  if (marker.frame.size() > kMaxFrameBytes) {
    if (found != entries.end()) erase(found->second, context);
    return warn(context, topic, marker.name,
                "the name of its frame has more than " + std::to_string(kMaxFrameBytes) + " bytes");
  }
  Entry& entry = found == entries.end() ? entries[marker.name] : found->second;
  if (found != entries.end()) release(entry);
  entry.topic = topic;
  entry.marker = std::move(marker);
  entry.sequence = next_sequence_++;
  if (entry.marker.is_frame_locked) locked_.emplace(entry.sequence, &entry);
  set_end(entry, context);
  if (const Transform* const fixed_from_frame = context.find_transform(entry.marker.frame)) {
    entry.fixed_from_marker = *fixed_from_frame * entry.marker.frame_from_marker;
    if (entry.marker.lifetime_ns == 0 || entry.end_ns) {
      send(entry, context);
      return;
    }
  }
  hold(entry, context);
}

void MarkerStore::clear(const std::string& topic, const std::string& name, const MarkerContext& context) {
  const auto entries = topics_.find(topic);
  if (entries == topics_.end()) return;
  if (const auto found = entries->second.find(name); found != entries->second.end())
    erase(found->second, context);
}

void MarkerStore::clear_topic(const std::string& topic, const MarkerContext& context) {
  const auto entries = topics_.find(topic);
  if (entries == topics_.end()) return;
  while (!entries->second.empty()) erase(entries->second.begin()->second, context);
}

// The end counts from the message, also for a marker that is held.
void MarkerStore::set_end(Entry& entry, const MarkerContext& context) {
  if (entry.marker.lifetime_ns == 0 || !context.sim_time_ns) return;
  entry.end_ns = *context.sim_time_ns + static_cast<int64_t>(entry.marker.lifetime_ns);
  ends_.emplace(*entry.end_ns, entry.sequence, &entry);
}

// Sends the marker with its transform. One that is refused is erased: its old version is out of date.
void MarkerStore::send(Entry& entry, const MarkerContext& context) {
  const ShownMarker& marker = entry.marker;
  const std::array<float, 12> pose = matrix_of(entry.fixed_from_marker);
  fire3dv_marker sent = {};
  sent.struct_size = sizeof sent;
  sent.kind = marker.kind;
  sent.width_unit = FIRE3DV_MARKER_LENGTHS;
  sent.width = marker.width_m;
  if (entry.end_ns)
    sent.lifetime_ns = static_cast<uint64_t>(std::max<int64_t>(1, *entry.end_ns - *context.sim_time_ns));
  sent.parent_from_marker = pose.data();
  sent.positions = marker.positions.data();
  sent.position_count = marker.positions.size() / 3;
  sent.sizes = marker.sizes.empty() ? nullptr : marker.sizes.data();
  sent.size_count = marker.sizes.size() / 3;
  sent.colors = marker.colors.data();
  sent.color_count = marker.colors.size() / 4;
  std::vector<const char*> texts;
  for (const std::string& text : marker.texts) texts.push_back(text.c_str());
  sent.texts = texts.empty() ? nullptr : texts.data();
  sent.text_count = texts.size();
  const Result<void> done = context.show(marker.name, &sent);
  if (done) {
    entry.is_shown = true;
    return;
  }
  warn(context, entry.topic, marker.name, done.error().message);
  erase(entry, context);
}

void MarkerStore::hide(Entry& entry, const MarkerContext& context) {
  if (!std::exchange(entry.is_shown, false)) return;
  if (const Result<void> done = context.show(entry.marker.name, nullptr); !done)
    context.warn(kind_of(entry.topic), "/" + entry.topic + ": marker " + quote(entry.marker.name) +
                                           " is not cleared: " + done.error().message);
}

void MarkerStore::hold(Entry& entry, const MarkerContext& context) {
  hide(entry, context);
  held_.emplace(entry.sequence, &entry);
  held_bytes_ += bytes_of(entry.marker);
  MissingFrame& frame = missing_[entry.marker.frame];
  if (frame.markers++ == 0) frame.since_ns = context.now_ns;
  while (held_bytes_ > limits_.held_bytes) drop_oldest_held(context);
}

void MarkerStore::release(Entry& entry) {
  if (entry.end_ns) ends_.erase({*entry.end_ns, entry.sequence, &entry});
  entry.end_ns.reset();
  locked_.erase(entry.sequence);
  unhold(entry);
}

void MarkerStore::unhold(const Entry& entry) {
  if (held_.erase(entry.sequence) == 0) return;
  held_bytes_ -= bytes_of(entry.marker);
  const auto frame = missing_.find(entry.marker.frame);
  if (--frame->second.markers == 0) missing_.erase(frame);
}

void MarkerStore::erase(Entry& entry, const MarkerContext& context) {
  release(entry);
  hide(entry, context);
  Entries& entries = topics_[entry.topic];
  entries.erase(entries.find(entry.marker.name));
}

void MarkerStore::drop_oldest_held(const MarkerContext& context) {
  Entry& oldest = *held_.begin()->second;
  context.warn("markers without a transform",
               "/" + oldest.topic + ": " + quote(oldest.marker.name) +
                   " is dropped: markers whose frames are not connected to the fixed frame, such as " +
                   quote(oldest.marker.frame) + ", take more than " +
                   std::to_string(limits_.held_bytes >> 20) + " MiB");
  erase(oldest, context);
}

void MarkerStore::clear_expired(const MarkerContext& context) {
  if (!context.sim_time_ns) return;
  if (!sim_time_ns_) {  // markers that came before the first time begin now
    for (const auto& [sequence, entry] : held_) set_end(*entry, context);
    return;
  }
  const int64_t now = *context.sim_time_ns;
  std::vector<Entry*> expired;
  for (const auto& [end_ns, sequence, entry] : ends_) {
    const bool has_begun = end_ns - static_cast<int64_t>(entry->marker.lifetime_ns) <= now;
    if (end_ns < now || !has_begun)
      expired.push_back(entry);
    else if (now >= *sim_time_ns_)
      break;  // time goes on: later ends are in the future, too
  }
  for (Entry* const entry : expired) erase(*entry, context);
}

// A marker whose frame has no path to the fixed frame stays where it was.
void MarkerStore::follow_frames(const MarkerContext& context) {
  std::vector<Entry*> moved;
  for (const auto& [sequence, entry] : locked_) {
    const Transform* const fixed_from_frame =
        entry->is_shown ? context.find_transform(entry->marker.frame) : nullptr;
    if (!fixed_from_frame) continue;
    const Transform now = *fixed_from_frame * entry->marker.frame_from_marker;
    if (matrix_of(now) == matrix_of(entry->fixed_from_marker)) continue;
    entry->fixed_from_marker = now;
    moved.push_back(entry);
  }
  for (Entry* const entry : moved) send(*entry, context);
}

// Frames move between a message and now: the transform in the old fixed frame is more accurate than a new one
// by the marker's own frame.
void MarkerStore::change_fixed_frame(const MarkerContext& context) {
  const std::string old = std::exchange(fixed_frame_, context.fixed_frame);
  std::optional<Transform> new_from_old;
  if (const Transform* const found = old.empty() ? nullptr : context.find_transform(old))
    new_from_old = *found;
  std::vector<Entry*> shown;
  for (auto& [topic, entries] : topics_)
    for (auto& [name, entry] : entries)
      if (entry.is_shown) shown.push_back(&entry);
  for (Entry* const entry : shown) {
    if (new_from_old) {
      entry->fixed_from_marker = *new_from_old * entry->fixed_from_marker;
    } else if (const Transform* const fixed_from_frame = context.find_transform(entry->marker.frame)) {
      entry->fixed_from_marker = *fixed_from_frame * entry->marker.frame_from_marker;
    } else {
      hold(*entry, context);
      continue;
    }
    send(*entry, context);
  }
}

void MarkerStore::show_held(const MarkerContext& context) {
  std::vector<std::string> found;
  for (const auto& [frame, missing] : missing_)
    if (context.find_transform(frame)) found.push_back(frame);
  if (found.empty()) return;
  std::vector<Entry*> ready;  // in order of arrival
  for (const auto& [sequence, entry] : held_)
    if ((entry->marker.lifetime_ns == 0 || entry->end_ns) &&
        std::binary_search(found.begin(), found.end(), entry->marker.frame))
      ready.push_back(entry);
  for (Entry* const entry : ready) {
    entry->fixed_from_marker = *context.find_transform(entry->marker.frame) * entry->marker.frame_from_marker;
    unhold(*entry);
    send(*entry, context);
  }
}

void MarkerStore::report_missing_frames(const MarkerContext& context) {
  const auto is_due = [&](const MissingFrame& frame) {
    return !frame.is_reported && context.now_ns - frame.since_ns >= kPatienceNs;
  };
  if (std::none_of(missing_.begin(), missing_.end(), [&](const auto& frame) { return is_due(frame.second); }))
    return;
  for (const auto& [sequence, entry] : held_) {
    const std::string& name = entry->marker.frame;
    MissingFrame& frame = missing_.at(name);
    if (!is_due(frame) || context.find_transform(name)) continue;
    frame.is_reported = true;
    const std::string others =
        frame.markers == 1 ? "" : "; " + counted(frame.markers - 1, "other marker") + " of it, too";
    warn(context, entry->topic, entry->marker.name,
         "frame " + quote(name) + " is not connected to the fixed frame " + quote(fixed_frame_) + others);
  }
}

}  // namespace fire3dv::ros2
