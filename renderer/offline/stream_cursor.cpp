#include "renderer/offline/stream_cursor.h"

#include <algorithm>

#include "renderer/state/playout/interpolate.h"

namespace fire3dv::offline {
namespace {

constexpr uint64_t kMaxPendingBytes = uint64_t{256} << 20;  // as for a live stream

}  // namespace

StreamCursor::StreamCursor(record::Playback playback, size_t stream, const Timeline& timeline)
    : playback_(std::move(playback)), stream_(stream), timeline_(timeline) {
  playback_.rewind();
}

const StreamCursor::Effect* StreamCursor::peek() {
  while (queue_.empty() && !at_end_) fill();
  return queue_.empty() ? nullptr : &queue_.front();
}

StreamCursor::Effect StreamCursor::take() {
  Effect effect = std::move(queue_.front());
  queue_.pop_front();
  if (effect.kind == Effect::Kind::edit) return effect;
  if (effect.kind == Effect::Kind::frame)
    shown_ = std::move(effect.frame);
  else
    shown_.reset();
  shown_way_ = -1;
  return effect;
}

void StreamCursor::queue(Effect effect) {
  newest_ns_ = effect.at_ns = std::max(effect.at_ns, newest_ns_);
  queue_.push_back(std::move(effect));
}

// Reads until an effect is queued or the file ends. A run that the timeline does not list was written after
// the timeline was read: the stream ends there.
void StreamCursor::fill() {
  const Timeline::StreamTimes& times = timeline_.streams()[stream_];
  record::Played played;
  while (queue_.empty() && !at_end_) {
    const record::Playback::Step step = playback_.next(played);
    at_end_ = step == record::Playback::Step::end;
    if (step != record::Playback::Step::played || played.stream != stream_) continue;
    const StreamFrames::Taken taken = frames_.take(played);
    // Time of a message that no frame follows.
    const auto by_guide = [&] {
      const int64_t after_ns = newest_ns_ == kAlways ? kAlways : newest_ns_ + 1;
      return std::max(after_ns, timeline_.guide_at(played.log_time_ns));
    };
    if (taken.began) {
      if (runs_ == times.runs.size()) break;
      const int64_t at_ns = std::min(times.runs[runs_].first_ns, by_guide());
      ++runs_;
      frames_in_run_ = 0;
      queue({Effect::Kind::begin,
             at_ns,
             played.log_time_ns,
             {played.message.begin(), played.message.end()},
             {}});
    }
    if (taken.edited) {
      if (frames_in_run_ < times.runs[runs_ - 1].frames) {
        keep_edit(played);
      } else {
        queue({Effect::Kind::edit,
               by_guide(),
               played.log_time_ns,
               {played.message.begin(), played.message.end()},
               {}});
      }
    }
    if (taken.frame) {
      if (taken.segment) ++segments_;
      if (segments_ == 0 || segments_ > times.segments.size()) break;
      const size_t segment = segments_ - 1;
      const int64_t at_ns = frames_.header().sim_time_ns + times.segments[segment].line_from_sim_ns;
      ++frames_in_run_;
      for (auto& [order, edit] : pending_)
        queue({Effect::Kind::edit, at_ns, edit.log_time_ns, std::move(edit.message), {}});
      pending_.clear();
      order_of_key_.clear();
      pending_bytes_ = 0;
      queue({Effect::Kind::frame,
             at_ns,
             played.log_time_ns,
             {},
             {frames_.header(), {frames_.poses().begin(), frames_.poses().end()}, at_ns, segment}});
    }
    if (taken.ended) queue({Effect::Kind::end, by_guide(), played.log_time_ns, {}, {}});
  }
  at_end_ = at_end_ || queue_.empty();
}

void StreamCursor::keep_edit(const record::Played& played) {
  if (const auto known = order_of_key_.find(played.edit_key); known != order_of_key_.end()) {
    pending_bytes_ -= pending_[known->second].message.size();
    pending_.erase(known->second);
    order_of_key_.erase(known);
  }
  if (pending_bytes_ + played.message.size() > kMaxPendingBytes) {
    ++left_out_;
    return;
  }
  pending_bytes_ += played.message.size();
  order_of_key_[played.edit_key] = next_order_;
  pending_[next_order_++] = {
      played.edit_key, played.log_time_ns, {played.message.begin(), played.message.end()}};
}

const StreamCursor::Frame* StreamCursor::next_frame() const {
  for (const Effect& effect : queue_) {
    if (effect.kind == Effect::Kind::frame) return &effect.frame;
    if (effect.kind != Effect::Kind::edit) return nullptr;  // the run ends first
  }
  return nullptr;
}

std::optional<StreamCursor::Moment> StreamCursor::at(int64_t line_ns) {
  if (!shown_) return {};
  (void)peek();
  const Frame* const next = next_frame();
  const Timeline::Segment& segment = timeline_.streams()[stream_].segments[shown_->segment];
  const bool joined =
      next && next->segment == shown_->segment && (next->header.flags & wire::kFrameDiscontinuity) == 0 &&
      next->at_ns - shown_->at_ns <= segment.hold_ns && next->poses.size() == shown_->poses.size();
  const double way =
      joined && next->at_ns > shown_->at_ns
          ? static_cast<double>(line_ns - shown_->at_ns) / static_cast<double>(next->at_ns - shown_->at_ns)
          : 0;
  Moment moment{shown_->header, shown_->poses, false};
  moment.header.sim_time_ns = way > 0 ? line_ns - segment.line_from_sim_ns : shown_->header.sim_time_ns;
  const uint64_t next_sequence = way > 0 ? next->header.sequence : 0;
  moment.changed =
      shown_sequence_ != shown_->header.sequence || shown_next_ != next_sequence || shown_way_ != way;
  shown_sequence_ = shown_->header.sequence;
  shown_next_ = next_sequence;
  shown_way_ = way;
  if (way == 0) return moment;
  if (moment.changed) {
    between_.resize(next->poses.size());
    for (size_t i = 0; i < between_.size(); ++i)
      between_[i] = state::interpolate(shown_->poses[i], next->poses[i], way);
  }
  moment.poses = between_;
  return moment;
}

}  // namespace fire3dv::offline
