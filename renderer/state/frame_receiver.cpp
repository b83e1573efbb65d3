#include "renderer/state/frame_receiver.h"

#include <algorithm>

namespace fire3dv::state {

FrameReceiver::FrameReceiver(uint64_t run_epoch, size_t node_count, std::shared_ptr<PeerBudget> budget)
    : budget_(std::move(budget)),
      node_count_(node_count),
      assembler_(budget_),
      edits_(budget_),
      scalars_(budget_),
      inputs_(budget_),
      queue_(budget_),
      memory_(budget_) {
  epoch = run_epoch;
}

bool FrameReceiver::push(const wire::PoseFrameView& frame, int64_t published_ns, int64_t received_ns) {
  // A whole frame is not stale if its sequence was only received in part: it completes that frame.
  const bool completes_partial =
      frame.header.sequence == newest_sequence_ && newest_is_partial_ && frame.node_indices.empty();
  if (frame.header.epoch != epoch || (frame.header.sequence <= header.sequence && !completes_partial)) {
    ++frames_stale;
    return false;
  }
  if (frame.node_count != node_count_) {
    ++frames_refused;
    return false;
  }
  if (!frame.node_indices.empty()) return push_partial(frame, published_ns, received_ns);
  if (frame.first_node == 0 && frame.poses.size() == frame.node_count)
    return push_whole({frame.header, frame.poses, published_ns, received_ns});
  using Outcome = stream::FrameAssembler::Outcome;
  const Outcome outcome = assembler_.add(frame);
  frames_incomplete += assembler_.take_given_up();
  switch (outcome) {
    case Outcome::whole:
      return push_whole({assembler_.header(), assembler_.poses(), published_ns, received_ns});
    case Outcome::open:
      break;
    case Outcome::stale:
      ++frames_stale;
      break;
    case Outcome::refused:
      ++frames_refused;
      break;
    case Outcome::over_budget:
      return refuse_frame();
  }
  return false;
}

// Drops a frame that exceeds the peer's budget, and reports it.
bool FrameReceiver::refuse_frame() {
  ++frames_refused;
  if (!budget_) return false;
  const uint64_t used = budget_->used(Resource::pose_bytes);
  report_refusal(
      Resource::pose_bytes,
      "pose frames use " + amount_text(Resource::pose_bytes, used) + " of " +
          amount_text(Resource::pose_bytes, budget_->limit(Resource::pose_bytes)) +
          " of this peer, and the next frame has no room there or in what all peers share (the renderer's "
          "options --peer-limit pose-bytes=VALUE and shared-pose-bytes=VALUE change it)");
  return false;
}

void FrameReceiver::report_refusal(Resource resource, const std::string& message) {
  const uint32_t bit = 1u << static_cast<uint32_t>(resource);
  if ((std::exchange(reported_refusals_, reported_refusals_ | bit) & bit) == 0)
    refusals_.push_back({resource, message});
}

// Merges a partial frame over the newest received frame, whether that is shown yet or not.
bool FrameReceiver::push_partial(const wire::PoseFrameView& frame, int64_t published_ns,
                                 int64_t received_ns) {
  if (newest_sequence_ == 0) {
    ++frames_without_base;
    return false;
  }
  if (frame.header.sequence <= newest_sequence_) {
    ++frames_stale;
    return false;
  }
  const std::vector<wire::Affine3x4>& base = !queue_.empty() ? queue_.newest().poses
                                             : playout_      ? newest_poses_
                                                             : poses;
  if (base.size() != frame.node_count || !memory_.reserve(merged_, base.size())) return refuse_frame();
  merged_.assign(base.begin(), base.end());
  for (size_t i = 0; i < frame.poses.size(); ++i) merged_[frame.node_indices[i]] = frame.poses[i];
  const bool changed = push_whole({frame.header, merged_, published_ns, received_ns});
  newest_is_partial_ = true;
  return changed;
}

bool FrameReceiver::push_whole(const Frame& frame) {
  if (frame.received_ns != 0) liveness_.on_frame(frame.received_ns);
  if (frame.header.sequence == newest_sequence_ && newest_is_partial_) return complete_partial(frame);
  if (frame.header.scene_version <= edits_.applied()) return accept(frame);
  if (frame.header.sequence <= newest_sequence_) {  // frames older than a queued frame do not queue
    ++frames_stale;
    return false;
  }
  const FrameQueue::Outcome queued =
      queue_.push(frame.header, frame.poses, frame.published_ns, frame.received_ns);
  if (queued == FrameQueue::Outcome::over_budget) return refuse_frame();
  newest_sequence_ = frame.header.sequence;
  newest_is_partial_ = false;
  ++frames_queued;
  if (queued == FrameQueue::Outcome::replaced) ++frames_superseded;
  assembler_.close(newest_sequence_);
  return false;
}

// Shows or buffers a frame whose edits are applied. Returns true if it is shown immediately.
bool FrameReceiver::accept(const Frame& frame) {
  if (!memory_.reserve(playout_ ? newest_poses_ : poses, frame.poses.size())) return refuse_frame();
  frames_superseded += queue_.drop_up_to(frame.header.sequence);
  if (frame.header.sequence >= newest_sequence_) {
    if (frame.header.sequence > newest_sequence_) newest_is_partial_ = false;
    newest_sequence_ = frame.header.sequence;
    if (playout_) newest_poses_.assign(frame.poses.begin(), frame.poses.end());
  }
  if (!playout_) {
    show(frame.header, frame.poses);
    ++frames_received;
    return true;
  }
  assembler_.close(frame.header.sequence);  // the buffer has it: it is whole, not superseded
  if (playout_->add(frame.header, frame.poses, frame.published_ns, frame.received_ns))
    ++frames_received;
  else if (playout_->over_budget())
    return refuse_frame();
  else
    ++frames_stale;
  return false;  // advance() shows it at its due time
}

// Completes the newest frame after a partial one of the same sequence.
bool FrameReceiver::complete_partial(const Frame& frame) {
  newest_is_partial_ = false;
  bool changed = false;
  if (!queue_.empty()) {  // the newest queued frame has this sequence
    const QueuedFrame& queued = queue_.newest();
    if (queue_.push(frame.header, frame.poses, queued.published_ns, queued.received_ns) ==
        FrameQueue::Outcome::over_budget)
      return refuse_frame();
  } else if (playout_) {
    newest_poses_.assign(frame.poses.begin(), frame.poses.end());
    playout_->replace(frame.header.sequence, frame.poses);
  } else if (!std::equal(frame.poses.begin(), frame.poses.end(), poses.begin(), poses.end())) {
    show(frame.header, frame.poses);
    changed = true;
  }
  assembler_.close(newest_sequence_);
  return changed;
}

bool FrameReceiver::release_queued() {
  bool changed = false;
  while (const QueuedFrame* queued = queue_.release(edits_.applied()))
    changed |= accept({queued->header, queued->poses, queued->published_ns, queued->received_ns});
  return changed;
}

bool FrameReceiver::apply(wire::SceneEdit&& edit) {
  if (edit.epoch != epoch) return count_edit(StreamEdits::Outcome::stale);
  if (wire::is_scalar(edit.property)) return apply_scalars(edit);
  if (edit.property == wire::Property::input) return apply_input(edit);
  const StreamEdits::Outcome outcome = edits_.add(std::move(edit));
  if (outcome == StreamEdits::Outcome::refused) report_refusal(edits_.refused_resource(), edits_.refusal());
  return count_edit(outcome);
}

// Scalars are in effect immediately: each sample counts, not only the newest of a key before take_edits().
bool FrameReceiver::apply_scalars(const wire::SceneEdit& edit) {
  if (edits_.skip(edit.version) == StreamEdits::Outcome::stale)
    return count_edit(StreamEdits::Outcome::stale);
  switch (scalars_.apply(edit)) {
    case stream::ScalarHistory::Outcome::accepted:
      break;
    case stream::ScalarHistory::Outcome::unmatched:
      ++scalars_unmatched;
      break;
    case stream::ScalarHistory::Outcome::refused:
      report_refusal(Resource::edit_bytes, scalars_.refusal());
      return count_edit(StreamEdits::Outcome::refused);
  }
  return count_edit(StreamEdits::Outcome::accepted);
}

bool FrameReceiver::apply_input(const wire::SceneEdit& edit) {
  if (edits_.skip(edit.version) == StreamEdits::Outcome::stale)
    return count_edit(StreamEdits::Outcome::stale);
  if (const Result<void> taken = inputs_.apply(edit); !taken) {
    report_refusal(Resource::edit_bytes, taken.error().message);
    return count_edit(StreamEdits::Outcome::refused);
  }
  return count_edit(StreamEdits::Outcome::accepted);
}

bool FrameReceiver::apply(const wire::UnknownEdit& edit) {
  return count_edit(edit.epoch != epoch ? StreamEdits::Outcome::stale : edits_.skip(edit.version));
}

bool FrameReceiver::count_edit(StreamEdits::Outcome outcome) {
  switch (outcome) {
    case StreamEdits::Outcome::accepted:
      ++edits_received;
      break;
    case StreamEdits::Outcome::stale:
      ++edits_stale;
      return false;
    case StreamEdits::Outcome::refused:
      ++edits_refused;
      break;
  }
  return release_queued();
}

bool FrameReceiver::finish_edit(uint64_t version) {
  edits_.finish(version);
  return release_queued();
}

void FrameReceiver::interpolate(std::optional<int64_t> fixed_delay_ns) {
  // Base of later partial frames.
  if (!playout_ && newest_sequence_ != 0 && memory_.reserve(newest_poses_, poses.size()))
    newest_poses_.assign(poses.begin(), poses.end());
  interpolated = true;
  playout_.emplace(fixed_delay_ns, budget_);
}

void FrameReceiver::show_newest(int64_t now_ns) {
  if (!playout_) return;
  constexpr int64_t kBeyondAllDelaysNs = 60'000'000'000;
  if (const auto last = playout_->at(now_ns + kBeyondAllDelaysNs); last && last->changed)
    show(last->header, last->poses);
  playout_.reset();
  interpolated = false;
}

bool FrameReceiver::advance(int64_t now_ns) {
  condition = liveness_.at(now_ns);
  if (!playout_) return false;
  const auto due = playout_->at(now_ns);
  if (!due || !due->changed) return false;
  show(due->header, due->poses);
  return true;
}

void FrameReceiver::show(const wire::PoseFrameHeader& shown, std::span<const wire::Affine3x4> shown_poses) {
  if (!memory_.reserve(poses, shown_poses.size())) return (void)refuse_frame();
  poses.assign(shown_poses.begin(), shown_poses.end());
  header = shown;
  ++revision;
  frames_incomplete += assembler_.close_up_to(header.sequence);
}

}  // namespace fire3dv::state
