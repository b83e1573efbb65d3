#include "protocol/frames/frame_buffer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"

namespace fire3dv::frames {
namespace {

constexpr size_t kMaxConflicts = 64;
constexpr int64_t kBeginningNs = 100'000'000;  // a stamp below it is a simulation that begins
constexpr double kMaxMetres = 1e9;             // beyond it float poses have no use

std::string_view without_slash(std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);
  return name;
}

bool is_good_name(std::string_view name) {
  if (name.empty() || name.size() > FrameBuffer::kMaxNameBytes) return false;
  for (size_t at = 0; at < name.size();) {
    const uint32_t character = next_character(name, at);
    if (character == kInvalidCharacter || is_control(character)) return false;
  }
  return true;
}

Insertion check(const Transform& transform) {
  for (const double number : transform.translation)
    if (!std::isfinite(number) || std::fabs(number) > kMaxMetres) return Insertion::bad_number;
  double length = 0;
  for (const double number : transform.rotation) length += number * number;
  if (std::isnan(length)) return Insertion::bad_number;
  return std::fabs(length - 1) < 0.01 ? Insertion::accepted : Insertion::bad_rotation;
}

}  // namespace

const char* insertion_text(Insertion insertion) {
  switch (insertion) {
    case Insertion::accepted:
      return "accepted";
    case Insertion::repeated:
      return "its stamp was there already";
    case Insertion::too_old:
      return "it is more than 10 s older than the newest";
    case Insertion::bad_name:
      return "a frame name is empty, longer than 255 bytes or not printable UTF-8";
    case Insertion::same_frame:
      return "the frame is its own parent";
    case Insertion::bad_number:
      return "a number is NaN, infinite or beyond 1e9";
    case Insertion::bad_rotation:
      return "its quaternion has not length 1";
    case Insertion::too_many_frames:
      break;
  }
  return "there are 65536 frames already";
}

FrameId FrameBuffer::find(std::string_view name) const {
  const auto found = ids_.find(without_slash(name));
  return found == ids_.end() ? kNoFrame : found->second;
}

FrameId FrameBuffer::intern(std::string_view name) {
  if (const auto found = ids_.find(name); found != ids_.end()) return found->second;
  if (frames_.size() >= kMaxFrames) return kNoFrame;
  const FrameId id = static_cast<FrameId>(frames_.size());
  frames_.emplace_back().name = name;
  ids_.emplace(name, id);
  ++structure_version_;
  return id;
}

Insertion FrameBuffer::insert(std::string_view parent, std::string_view child, int64_t stamp_ns,
                              const Transform& parent_from_child, bool is_static, SourceId source,
                              int64_t arrival_ns) {
  parent = without_slash(parent);
  child = without_slash(child);
  if (const Insertion fault = check(parent_from_child); fault != Insertion::accepted) return fault;
  // Names that are known already are good.
  const auto known_child = ids_.find(child), known_parent = ids_.find(parent);
  if ((known_child == ids_.end() && !is_good_name(child)) ||
      (known_parent == ids_.end() && !is_good_name(parent)))
    return Insertion::bad_name;
  if (parent == child) return Insertion::same_frame;
  const FrameId id = intern(child), parent_id = intern(parent);
  if (id == kNoFrame || parent_id == kNoFrame) return Insertion::too_many_frames;

  Frame& frame = frames_[id];
  FrameSample sample{stamp_ns, parent_id, parent_from_child};
  sample.parent_from_frame.rotation = normalized(sample.parent_from_frame.rotation);
  const FrameId parent_before = frame.is_root() ? kNoFrame : frame.samples.back().parent;
  const bool had_value = !frame.is_root(), was_stamped = frame.is_stamped();
  note_source(frame, id, source, arrival_ns);
  if (frame.is_static != is_static) {
    frame.is_static = is_static;
    frame.samples.clear();
  }
  Insertion result = Insertion::accepted;
  if (is_static || stamp_ns == 0) {
    const bool changes = !had_value || frame.is_root() || frame.samples.back().parent != parent_id ||
                         frame.samples.back().parent_from_frame != sample.parent_from_frame;
    frame.samples.assign(1, std::move(sample));
    frame.source = source;
    frame.arrival_ns = arrival_ns;
    if (changes) ++static_version_;
  } else {
    result = insert_moving(frame, std::move(sample), source, arrival_ns);
  }
  if (frame.samples.back().parent != parent_before || frame.is_stamped() != was_stamped) ++structure_version_;
  return result;
}

// A conflict is A, B and A again: a publisher that replaces another one, after a restart, is none.
void FrameBuffer::note_source(Frame& frame, FrameId id, SourceId source, int64_t arrival_ns) {
  if (frame.source == 0) return;
  const bool back_again = source == frame.source && frame.other_source != 0 &&
                          frame.other_arrival_ns > frame.arrival_ns &&
                          arrival_ns - frame.other_arrival_ns < kSilenceNs;
  const bool in_turn =
      source != frame.source && source == frame.other_source && arrival_ns - frame.arrival_ns < kSilenceNs;
  if ((back_again || in_turn) && conflicts_.size() < kMaxConflicts)
    conflicts_.push_back({id, source, source == frame.source ? frame.other_source : frame.source});
}

Insertion FrameBuffer::insert_moving(Frame& frame, FrameSample&& sample, SourceId source,
                                     int64_t arrival_ns) {
  std::deque<FrameSample>& samples = frame.samples;
  if (!samples.empty() && samples.back().stamp_ns == 0) samples.clear();  // was unstamped
  const bool is_newest = samples.empty() || sample.stamp_ns > samples.back().stamp_ns;
  const bool other_is_alive = source != frame.source && arrival_ns - frame.arrival_ns < kSilenceNs;
  if (!is_newest) {
    const int64_t newest = samples.back().stamp_ns;
    if (source != frame.source) {
      frame.other_source = source;
      frame.other_arrival_ns = arrival_ns;
    }
    const bool goes_back =
        sample.stamp_ns < newest - kJumpBackNs || (sample.stamp_ns < kBeginningNs && newest >= kBeginningNs);
    if (goes_back && !other_is_alive) {
      if (sample.stamp_ns >= frame.back_stamp_ns) frame.has_gone_back = has_gone_back_ = true;
      frame.back_stamp_ns = sample.stamp_ns;
    }
    if (source == frame.source) frame.arrival_ns = arrival_ns;
    if (sample.stamp_ns < newest - kCacheNs) return Insertion::too_old;
    const auto position =
        std::lower_bound(samples.begin(), samples.end(), sample.stamp_ns,
                         [](const FrameSample& s, int64_t stamp) { return s.stamp_ns < stamp; });
    if (position->stamp_ns == sample.stamp_ns) return Insertion::repeated;
    samples.insert(position, std::move(sample));
    prune(frame);
    return Insertion::accepted;
  }
  if (source != frame.source) {
    frame.other_source = std::exchange(frame.source, source);
    frame.other_arrival_ns = frame.arrival_ns;
  }
  frame.arrival_ns = arrival_ns;
  frame.has_gone_back = false;
  frame.back_stamp_ns = INT64_MAX;
  samples.push_back(std::move(sample));
  prune(frame);
  return Insertion::accepted;
}

void FrameBuffer::prune(Frame& frame) const {
  std::deque<FrameSample>& samples = frame.samples;
  const int64_t newest = samples.back().stamp_ns;
  const int64_t oldest = newest >= INT64_MIN + kCacheNs ? newest - kCacheNs : INT64_MIN;
  while (samples.size() > 1 &&
         (samples[0].stamp_ns < oldest || samples[1].stamp_ns <= oldest_ns_ || samples.size() > kMaxSamples))
    samples.pop_front();
}

size_t FrameBuffer::forget_old() {
  size_t left = 0;
  for (Frame& frame : frames_) {
    if (frame.is_root()) continue;
    prune(frame);
    left += frame.samples.size();
  }
  return left;
}

bool FrameBuffer::has_jumped_back(int64_t now_ns) {
  if (!has_gone_back_) return false;
  size_t alive = 0, back = 0;
  for (const Frame& frame : frames_) {
    if (!frame.is_stamped()) continue;
    if (frame.has_gone_back) ++back;
    if (frame.has_gone_back || now_ns - frame.arrival_ns < kSilenceNs) ++alive;
  }
  has_gone_back_ = back > 0;
  return back > 0 && 2 * back >= alive;
}

void FrameBuffer::clear_moving() {
  for (Frame& frame : frames_) {
    if (frame.is_static) continue;
    frame.samples.clear();
    frame.has_gone_back = false;
    frame.back_stamp_ns = INT64_MAX;
    frame.source = frame.other_source = 0;
  }
  oldest_ns_ = INT64_MIN;
  ++structure_version_;
}

void FrameBuffer::remove_source(SourceId source) {
  for (Frame& frame : frames_) {
    if (frame.source != source) continue;
    frame.samples.clear();
    frame.source = frame.other_source = 0;
    frame.is_static = frame.has_gone_back = false;
  }
  ++structure_version_;
}

std::optional<FrameSample> FrameBuffer::at(const Frame& frame, int64_t time_ns) {
  const std::deque<FrameSample>& samples = frame.samples;
  if (samples.empty()) return std::nullopt;
  if (!frame.is_stamped()) return samples.back();
  if (time_ns < samples.front().stamp_ns || time_ns > samples.back().stamp_ns) return std::nullopt;
  if (time_ns == samples.back().stamp_ns) return samples.back();
  const auto newer = std::upper_bound(samples.begin(), samples.end(), time_ns,
                                      [](int64_t time, const FrameSample& s) { return time < s.stamp_ns; });
  const FrameSample& older = *(newer - 1);
  if (older.stamp_ns == time_ns || older.parent != newer->parent) {
    FrameSample sample = older;
    sample.stamp_ns = time_ns;
    return sample;
  }
  const double share =
      static_cast<double>(time_ns - older.stamp_ns) / static_cast<double>(newer->stamp_ns - older.stamp_ns);
  return FrameSample{time_ns, older.parent,
                     interpolate(older.parent_from_frame, newer->parent_from_frame, share)};
}

FrameSample FrameBuffer::clamped(const Frame& frame, int64_t time_ns) {
  if (!frame.is_stamped()) return frame.samples.back();
  const int64_t least = frame.samples.front().stamp_ns, most = frame.samples.back().stamp_ns;
  return *at(frame, std::clamp(time_ns, least, most));
}

std::vector<FrameConflict> FrameBuffer::take_conflicts() {
  return std::exchange(conflicts_, {});
}

}  // namespace fire3dv::frames
