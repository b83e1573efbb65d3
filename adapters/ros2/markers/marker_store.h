// Markers by topic and name, with their transforms in the fixed frame. No DDS: messages are converted before.
//
// Transform: a marker stands where its frame is when its message comes, and a locked one follows its frame,
// in steps of a 30th of a second. One whose frame has no path to the
// fixed frame is held until there is one. A change of the fixed frame updates all transforms: they stay where
// they are in the old one. Lifetime: simulated time, that of the published pose frames, as in the renderer; a
// paused simulator keeps its markers. A marker is cleared when its lifetime is over, or when time goes back.
// It is held until there is a time.
#pragma once

#include <fire3dv/markers.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "adapters/ros2/markers/message_markers.h"
#include "adapters/ros2/tf/frames.h"
#include "base/error.h"
#include "protocol/wire/limits.h"

namespace fire3dv::ros2 {

// Frames, renderers and times of one call of the store.
struct MarkerContext {
  std::string fixed_frame;
  // fixed_from_frame of a frame now; null: it has no path to the fixed frame. Valid until the next call.
  std::function<const Transform*(const std::string& frame)> find_transform;
  // Sets a marker, or clears it (null), in all renderers.
  std::function<Result<void>(const std::string& name, const fire3dv_marker* marker)> show;
  // kind: of warnings of which a few are enough.
  std::function<void(const std::string& kind, const std::string& text)> warn;
  int64_t now_ns = 0;                  // monotonic
  std::optional<int64_t> sim_time_ns;  // of the pose frame published last; none: nothing was published
};

class MarkerStore {
 public:
  struct Limits {
    size_t markers_per_topic = 20'000;
    size_t held_bytes =
        wire::kMaxSceneEditBytes;  // of markers without a transform; shown ones are in the stream's budget
  };

  MarkerStore() = default;
  explicit MarkerStore(const Limits& limits) : limits_(limits) {}

  // Clears what has expired, updates markers after a change of the fixed frame, shows held ones that have
  // a transform now, and warns about frames that lack one for 3 s. Call it before messages are taken.
  void update(const MarkerContext& context);

  // Sets or replaces the marker of this name. What is not shown is reported, with topic and reason.
  void set(const std::string& topic, ShownMarker marker, const MarkerContext& context);
  void clear(const std::string& topic, const std::string& name, const MarkerContext& context);
  void clear_topic(const std::string& topic, const MarkerContext& context);

  size_t size(const std::string& topic) const;       // shown and held
  size_t held_bytes() const { return held_bytes_; }  // of held markers

 private:
  struct Entry {
    std::string topic;
    ShownMarker marker;
    uint64_t sequence = 0;          // order of arrival
    bool is_shown = false;          // otherwise held
    Transform fixed_from_marker;    // of a shown one
    std::optional<int64_t> end_ns;  // simulated time; none: no lifetime, or no time yet
  };
  struct MissingFrame {
    size_t markers = 0;  // held ones
    int64_t since_ns = 0;
    bool is_reported = false;
  };
  using Entries = std::map<std::string, Entry>;  // by name

  void send(Entry& entry, const MarkerContext& context);  // may erase it
  void hide(Entry& entry, const MarkerContext& context);
  void hold(Entry& entry, const MarkerContext& context);  // may erase it
  void unhold(const Entry& entry);
  void release(Entry& entry);  // from held markers and ends
  void erase(Entry& entry, const MarkerContext& context);
  void drop_oldest_held(const MarkerContext& context);
  void set_end(Entry& entry, const MarkerContext& context);
  void clear_expired(const MarkerContext& context);
  void follow_frames(const MarkerContext& context);
  void change_fixed_frame(const MarkerContext& context);
  void show_held(const MarkerContext& context);
  void report_missing_frames(const MarkerContext& context);

  Limits limits_;
  std::map<std::string, Entries> topics_;
  std::map<uint64_t, Entry*> held_;    // by sequence
  std::map<uint64_t, Entry*> locked_;  // by sequence: they follow their frames
  std::map<std::string, MissingFrame> missing_;
  std::set<std::tuple<int64_t, uint64_t, Entry*>> ends_;  // end_ns, sequence
  size_t held_bytes_ = 0;
  uint64_t next_sequence_ = 0;
  std::string fixed_frame_;
  std::optional<int64_t> sim_time_ns_;
  int64_t next_look_ns_ = 0, next_follow_ns_ = 0;
};

}  // namespace fire3dv::ros2
