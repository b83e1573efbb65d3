#include "protocol/import/pose_recorder.h"

#include <algorithm>
#include <cstdio>
#include <span>
#include <utility>

#include "base/text.h"

namespace fire3dv::imported {
namespace {

constexpr int64_t kAheadNs = 1'000'000'000;    // a frame waits so long for transforms of later stamps
constexpr int64_t kSilenceNs = 1'000'000'000;  // longer gaps are held, not interpolated
constexpr uint64_t kMaxSamples = 1'000'000;    // that wait; bounds the memory of hostile files

std::string seconds(int64_t time_ns) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9f s", static_cast<double>(time_ns - kTimeOffsetNs) * 1e-9);
  return text;
}

wire::StreamDescription describe(const Plan& plan) {
  wire::StreamDescription description;
  description.world_from_stream = plan.world_from_stream;
  bool has_scale = false;
  for (const SceneNode& node : plan.nodes) {
    description.node_names.push_back(node.name);
    description.body_from_node.push_back(node.body_from_node);
    has_scale = has_scale || node.body_from_node != wire::Affine3x4{};
  }
  if (!has_scale) description.body_from_node.clear();
  return description;
}

}  // namespace

Result<PoseRecorder> PoseRecorder::open(const std::string& file, const Plan& plan,
                                        std::unique_ptr<record::Sink> sink) {
  PoseRecorder recorder(file, plan);
  // Before its first transform a frame has this one.
  for (const SeenFrame& frame : plan.frames) {
    TransformSample first = frame.first;
    first.stamp_ns = std::min(first.stamp_ns, plan.first_ns);
    (void)recorder.insert(first, frame.is_static);
  }
  recorder.newest_ns_ = plan.first_ns;
  recorder.frame_of_node_.assign(plan.nodes.size(), frames::kNoFrame);
  const wire::Affine3x4d& world_from_stream = plan.world_from_stream;
  const frames::Transform stream_from_world = inverse(frames::transform_of(world_from_stream.m));
  for (const SceneNode& node : plan.nodes)
    recorder.poses_.push_back({matrix_of(stream_from_world * frames::transform_of(node.world_from_body))});
  Result<StreamWriter> writer =
      StreamWriter::open(std::move(sink), describe(plan), plan.first_ns - kTimeOffsetNs);
  if (!writer) return writer.error();
  recorder.writer_.emplace(std::move(*writer));
  return recorder;
}

bool PoseRecorder::insert(const TransformSample& sample, bool is_static) {
  const frames::FrameId id = buffer_.find(sample.child);
  if (!is_static && id != frames::kNoFrame) {
    const frames::Frame& frame = buffer_.frames()[id];
    if (frame.is_stamped() && frame.samples.back().stamp_ns < sample.stamp_ns - kSilenceNs) {
      const frames::FrameSample held = frame.samples.back();
      const std::string parent = buffer_.frames()[held.parent].name;
      (void)buffer_.insert(parent, sample.child, sample.stamp_ns - 1, held.parent_from_frame, false, 0, 0);
    }
  }
  const frames::Insertion done =
      buffer_.insert(sample.parent, sample.child, sample.stamp_ns, sample.parent_from_child, is_static, 0, 0);
  return done == frames::Insertion::accepted || done == frames::Insertion::repeated;
}

Result<void> PoseRecorder::add(const std::vector<TransformSample>& samples, bool is_static) {
  for (const TransformSample& sample : samples) {
    std::string_view child = sample.child;
    if (child.starts_with('/')) child.remove_prefix(1);
    if (!plan_->relevant.contains(child)) continue;
    const bool makes_frame = !is_static && plan_->moving.contains(child) && sample.stamp_ns > last_ns_;
    // Before it is inserted: it may be far ahead, so that the buffer forgets what these frames show.
    if (makes_frame) {
      newest_ns_ = std::max(newest_ns_, sample.stamp_ns);
      if (Result<void> written = write_before(newest_ns_ - kAheadNs); !written) return written;
    }
    const bool is_good = insert(sample, is_static);
    if (is_good && makes_frame && sample.stamp_ns > last_ns_) due_.insert(sample.stamp_ns);
    if (++inserted_ % kMaxSamples != 0 || buffer_.forget_old() < kMaxSamples) continue;
    if (Result<void> written = write_before(newest_ns_ + 1); !written) return written;
    (void)buffer_.forget_old();
  }
  return {};
}

Result<void> PoseRecorder::write_before(int64_t time_ns) {
  while (!due_.empty() && *due_.begin() < time_ns) {
    const int64_t next_ns = *due_.begin();
    due_.erase(due_.begin());
    if (Result<void> written = write_frame(next_ns); !written) return written;
  }
  return {};
}

Result<void> PoseRecorder::write_frame(int64_t time_ns) {
  // A frame may appear later: as the second parent of another one.
  const auto find = [this](frames::FrameId& id, const std::string& name) {
    if (id == frames::kNoFrame) id = buffer_.find(name);
    return id != frames::kNoFrame;
  };
  const bool has_origin = find(fixed_, plan_->fixed_frame);
  if (has_origin) tree_.begin(buffer_, fixed_, time_ns);
  for (size_t i = 0; has_origin && i < poses_.size(); ++i) {
    if (!find(frame_of_node_[i], plan_->frame_of_node[i])) continue;
    const frames::Transform* const pose = tree_.find(frame_of_node_[i]);
    if (pose) {
      poses_[i].m = matrix_of(*pose);
    } else if (tree_.is_in_loop(frame_of_node_[i])) {
      return Error{quote(file_) + ": at " + seconds(time_ns) + " the parents of frame " +
                   quote(plan_->frame_of_node[i]) +
                   " lead back to itself: record without the publisher that is wrong"};
    }
  }
  if (Result<void> written = writer_->write(time_ns - kTimeOffsetNs, poses_); !written) return written;
  last_ns_ = time_ns;
  buffer_.set_oldest_time(time_ns);
  return {};
}

Result<void> PoseRecorder::finish() {
  if (writer_->frames() == 0 && due_.empty()) due_.insert(newest_ns_);  // nothing moves
  if (Result<void> written = write_before(newest_ns_ + 1); !written) return written;
  return writer_->finish();
}

}  // namespace fire3dv::imported
