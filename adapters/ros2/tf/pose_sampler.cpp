#include "adapters/ros2/tf/pose_sampler.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kPlanEveryNs = 20 * kMs;
constexpr int64_t kQuietNs = 200 * kMs;
constexpr int64_t kLongestWaitNs = 2000 * kMs;
constexpr size_t kMaxReported = 4096;

}  // namespace

void PoseSampler::set_links(std::optional<std::vector<std::string>> links) {
  links_ = std::move(links);
  planned_version_.reset();
  next_plan_ns_ = 0;
}

void PoseSampler::restart() {
  restarts_ = true;
  last_time_ns_.reset();
  planned_version_.reset();
  next_plan_ns_ = 0;
}

std::vector<FrameId> PoseSampler::wanted_nodes(const FrameBuffer& buffer) const {
  std::vector<FrameId> wanted;
  if (links_) {
    for (const std::string& link : *links_)
      if (const FrameId id = buffer.find(options_.frame_prefix + link); id != kNoFrame) wanted.push_back(id);
    return wanted;
  }
  const std::vector<ros2::Frame>& frames = buffer.frames();
  for (FrameId id = 0; id < frames.size(); ++id)
    if (!frames[id].is_root() && frames[id].name.starts_with(options_.frame_prefix) &&
        frames[id].name.size() > options_.frame_prefix.size())
      wanted.push_back(id);
  return wanted;
}

size_t PoseSampler::count_connected(const FrameBuffer& buffer, FrameId fixed,
                                    const std::vector<FrameId>& wanted) {
  tree_.begin(buffer, fixed, std::nullopt);
  return static_cast<size_t>(
      std::count_if(wanted.begin(), wanted.end(), [&](FrameId id) { return tree_.find(id) != nullptr; }));
}

FrameId PoseSampler::choose_fixed(const FrameBuffer& buffer, const std::vector<FrameId>& wanted) {
  if (!options_.fixed_frame.empty()) return buffer.find(options_.fixed_frame);
  for (const char* usual : {"map", "odom", "world"}) {
    const FrameId id = buffer.find(usual);
    if (id != kNoFrame && count_connected(buffer, id, wanted) > 0) return id;
  }
  std::unordered_map<FrameId, size_t> nodes_of_root;
  std::unordered_map<FrameId, FrameId> roots;
  tree_.begin(buffer, kNoFrame, std::nullopt);
  FrameId best = kNoFrame;
  for (const FrameId id : wanted) {
    tree_.find(id);
    if (tree_.is_in_loop(id)) continue;
    const FrameId root = tree_.root_of(id, roots);
    const size_t count = ++nodes_of_root[root];
    if (best == kNoFrame || count > nodes_of_root[best]) best = root;
  }
  return best;
}

PoseSampler::Layout PoseSampler::plan(const FrameBuffer& buffer) {
  const std::vector<FrameId> wanted = wanted_nodes(buffer);
  Layout layout;
  layout.fixed = choose_fixed(buffer, wanted);
  if (layout.fixed == kNoFrame) return layout;
  tree_.begin(buffer, layout.fixed, std::nullopt);
  for (const FrameId id : wanted)
    if ((links_ || id != layout.fixed) && tree_.find(id)) layout.nodes.push_back(id);
  return layout;
}

void PoseSampler::consider(const FrameBuffer& buffer, int64_t now_ns) {
  if (planned_version_ == buffer.structure_version() || now_ns < next_plan_ns_) return;
  planned_version_ = buffer.structure_version();
  next_plan_ns_ = now_ns + kPlanEveryNs;
  Layout layout = plan(buffer);
  if (layout.nodes.empty() || (!restarts_ && layout_ == layout)) {
    pending_.reset();
    return;
  }
  if (!pending_) first_pending_ns_ = now_ns;
  if (pending_ == layout) return;
  pending_ = std::move(layout);
  pending_since_ns_ = now_ns;
  const std::unordered_set<FrameId> next(pending_->nodes.begin(), pending_->nodes.end());
  pending_shrinks_ = layout_ && std::any_of(layout_->nodes.begin(), layout_->nodes.end(),
                                            [&](FrameId id) { return !next.contains(id); });
}

bool PoseSampler::is_due(const FrameBuffer& buffer, int64_t now_ns) {
  if (!pending_) return false;
  if (restarts_ && pending_ == layout_) return true;
  if (now_ns - first_pending_ns_ >= kLongestWaitNs) return true;
  if (now_ns - pending_since_ns_ < (pending_shrinks_ ? kLongestWaitNs : kQuietNs)) return false;
  // A frame that is stamped ahead has no transform at the common time at first.
  tree_.begin(buffer, pending_->fixed, std::nullopt);
  const std::vector<FrameId> moving = tree_.moving_frames(pending_->nodes);
  const std::optional<int64_t> time_ns = common_time(buffer, moving, now_ns);
  return !time_ns || std::all_of(moving.begin(), moving.end(), [&](FrameId id) {
    const int64_t oldest = buffer.frames()[id].samples.front().stamp_ns;
    return oldest <= *time_ns || oldest > *time_ns + FrameBuffer::kCacheNs;
  });
}

void PoseSampler::adopt(const FrameBuffer& buffer) {
  layout_ = std::exchange(pending_, std::nullopt);
  names_.clear();
  for (const FrameId id : layout_->nodes)
    names_.push_back(buffer.frames()[id].name.substr(options_.frame_prefix.size()));
  poses_.assign(names_.size(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  moving_version_ = 0;
}

// The median decides which clock counts: of two frames with different clocks the later one.
std::optional<int64_t> PoseSampler::common_time(const FrameBuffer& buffer, const std::vector<FrameId>& moving,
                                                int64_t now_ns) {
  clock_faults_.clear();
  const auto collect = [&](bool only_alive) {
    newest_.clear();
    for (const FrameId id : moving) {
      const ros2::Frame& frame = buffer.frames()[id];
      if (frame.is_stamped() && (!only_alive || now_ns - frame.arrival_ns < FrameBuffer::kSilenceNs))
        newest_.push_back(frame.samples.back().stamp_ns);
    }
  };
  collect(true);
  if (newest_.empty()) {
    if (last_time_ns_) return last_time_ns_;
    collect(false);
  }
  if (newest_.empty()) return std::nullopt;
  const auto [least, most] = std::minmax_element(newest_.begin(), newest_.end());
  if (*most - *least <= FrameBuffer::kCacheNs) return *least;
  const auto middle = newest_.begin() + static_cast<ptrdiff_t>(newest_.size() / 2);
  std::nth_element(newest_.begin(), middle, newest_.end());
  const int64_t median = *middle;
  int64_t time_ns = median;
  for (const int64_t stamp : newest_)
    if (stamp >= median - FrameBuffer::kCacheNs) time_ns = std::min(time_ns, stamp);
  FrameId of_clock = kNoFrame;
  for (const FrameId id : moving) {
    const ros2::Frame& frame = buffer.frames()[id];
    if (frame.is_stamped() && frame.samples.back().stamp_ns == time_ns) of_clock = id;
  }
  for (const FrameId id : moving) {
    const ros2::Frame& frame = buffer.frames()[id];
    if (!frame.is_stamped() || now_ns - frame.arrival_ns >= FrameBuffer::kSilenceNs) continue;
    const int64_t stamp = frame.samples.back().stamp_ns;
    if (stamp < time_ns || frame.samples.front().stamp_ns > time_ns + FrameBuffer::kCacheNs)
      clock_faults_.push_back({FrameFault::Kind::other_clock, id, of_clock});
  }
  return time_ns;
}

void PoseSampler::evaluate(const FrameBuffer& buffer, int64_t time_ns) {
  tree_.begin(buffer, layout_->fixed, time_ns);
  for (size_t i = 0; i < layout_->nodes.size(); ++i)
    if (const Transform* pose = tree_.find(layout_->nodes[i])) poses_[i] = matrix_of(*pose);
}

std::optional<PoseSampler::Frame> PoseSampler::update(FrameBuffer& buffer, int64_t now_ns) {
  consider(buffer, now_ns);
  Frame frame;
  if (is_due(buffer, now_ns)) {
    adopt(buffer);
    frame.is_new_layout = frame.is_discontinuity = true;
    restarts_ = false;
  }
  if (!layout_ || restarts_) return std::nullopt;
  if (frame.is_new_layout || moving_version_ != buffer.structure_version()) {
    tree_.begin(buffer, layout_->fixed, std::nullopt);
    moving_ = tree_.moving_frames(layout_->nodes);
    moving_version_ = buffer.structure_version();
  }
  const std::optional<int64_t> common = common_time(buffer, moving_, now_ns);
  frame.time_ns = std::max(common.value_or(0), last_time_ns_.value_or(INT64_MIN));
  const bool is_newer = frame.is_new_layout || !last_time_ns_ || frame.time_ns > *last_time_ns_ ||
                        static_version_ != buffer.static_version();
  if (!is_newer) return std::nullopt;
  static_version_ = buffer.static_version();
  last_time_ns_ = frame.time_ns;
  evaluate(buffer, frame.time_ns);
  if (common) buffer.set_oldest_time(frame.time_ns);
  return frame;
}

std::vector<FrameFault> PoseSampler::new_faults(const FrameBuffer& buffer, bool patient) {
  std::vector<FrameFault> faults = clock_faults_;
  const FrameId fixed = layout_                        ? layout_->fixed
                        : options_.fixed_frame.empty() ? kNoFrame
                                                       : buffer.find(options_.fixed_frame);
  tree_.begin(buffer, fixed, std::nullopt);
  std::unordered_map<FrameId, FrameId> roots;
  for (const FrameId id : wanted_nodes(buffer)) {
    if (buffer.frames()[id].is_root() ? id == fixed : tree_.find(id) != nullptr) continue;
    tree_.find(id);
    if (tree_.is_in_loop(id))
      faults.push_back({FrameFault::Kind::loop, id, tree_.root_of(id, roots)});
    else if (patient)
      faults.push_back({FrameFault::Kind::unconnected, id, tree_.root_of(id, roots)});
  }
  for (FrameId id = 0; id < buffer.frames().size(); ++id) {
    const ros2::Frame& frame = buffer.frames()[id];
    if (!frame.is_static && !frame.is_root() && !frame.is_stamped())
      faults.push_back({FrameFault::Kind::no_stamp, id});
  }
  std::erase_if(faults, [&](const FrameFault& fault) {
    return reported_.size() >= kMaxReported ||
           std::find_if(reported_.begin(), reported_.end(), [&](const FrameFault& known) {
             return known.kind == fault.kind && known.frame == fault.frame;
           }) != reported_.end();
  });
  reported_.insert(reported_.end(), faults.begin(), faults.end());
  return faults;
}

}  // namespace fire3dv::ros2
