#include "protocol/import/survey.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"

namespace fire3dv::imported {
namespace {

constexpr size_t kMaxEdges = 4 * frames::FrameBuffer::kMaxFrames;
constexpr size_t kMaxJoints = 100'000;
constexpr size_t kShownNameBytes = 40;  // of a name that is too long

}  // namespace

SeenFrame& Survey::seen(frames::FrameId id) {
  if (seen_.size() < buffer_.frames().size()) seen_.resize(buffer_.frames().size());
  return seen_[id];
}

Result<void> Survey::add_transform(const Batch& batch, const TransformSample& sample) {
  using frames::Insertion;
  const Insertion done = buffer_.insert(sample.parent, sample.child, sample.stamp_ns,
                                        sample.parent_from_child, batch.is_static, 0, 0);
  if (done == Insertion::repeated) return {};
  if (done != Insertion::accepted) {
    faults_.add(batch, "transform", frames::insertion_text(done),
                "frame " + quote(sample.child) + " in " + quote(sample.parent));
    return {};
  }
  const frames::FrameId child = buffer_.find(sample.child), parent = buffer_.find(sample.parent);
  SeenFrame& frame = seen(child);
  if (!frame.is_child) {
    frame.is_child = true;
    frame.first = sample;
    frame.origin = "topic " + quote(batch.topic->name) + ", message " + std::to_string(batch.number);
  } else if (sample.stamp_ns != frame.first.stamp_ns) {
    frame.moves = true;
    if (sample.stamp_ns < frame.first.stamp_ns) frame.first = sample;
  }
  frame.is_static = batch.is_static;
  edges_.emplace(child, parent);
  if (edges_.size() > kMaxEdges)
    return Error{"the frames change their parents too often (topic " + quote(batch.topic->name) +
                 ", message " + std::to_string(batch.number) + "): the recording is damaged"};
  return {};
}

Result<void> Survey::add(const Batch& batch) {
  for (const TransformSample& sample : batch.transforms) {
    if (Result<void> added = add_transform(batch, sample); !added) return added;
  }
  if (!batch.joints) return {};
  const JointState& state = *batch.joints;
  first_joint_ns_ = std::min(first_joint_ns_, state.stamp_ns);
  for (size_t i = 0; i < state.names.size(); ++i) {
    if (state.names[i].size() > frames::FrameBuffer::kMaxNameBytes)
      faults_.add(batch, "position", "the joint's name is longer than 255 bytes",
                  "joint " + quote(state.names[i].substr(0, kShownNameBytes)) + "...");
    else if (!std::isfinite(state.positions[i]))
      faults_.add(batch, "position", "it is not finite", "joint " + quote(state.names[i]));
    else if (joints_.size() < kMaxJoints)
      joints_.emplace(state.names[i], state.positions[i]);
  }
  return {};
}

void Survey::add_link(const TransformSample& first) {
  (void)buffer_.insert(first.parent, first.child, first.stamp_ns, first.parent_from_child, false, 0, 0);
  const frames::FrameId child = buffer_.find(first.child), parent = buffer_.find(first.parent);
  if (child == frames::kNoFrame || parent == frames::kNoFrame) return;
  (void)seen(parent);
  SeenFrame& frame = seen(child);
  frame = {.is_child = true, .is_static = false, .moves = true, .first = first, .origin = "joint states"};
  edges_.emplace(child, parent);
}

}  // namespace fire3dv::imported
