#include "renderer/offline/recorded_streams.h"

#include <algorithm>
#include <tuple>

#include "protocol/wire/check.h"
#include "protocol/wire/limits.h"
#include "renderer/state/playout.h"

namespace fire3dv::offline {

namespace {

constexpr int64_t kMaxSimTimeNs = int64_t{1} << 62;  // 146 years: the difference of two does not overflow

constexpr uint64_t kMaxPendingBytes = wire::kMaxSceneEditBytes;  // edits between two frames
constexpr size_t kMaxNameBytes = 2048;                           // room for one name
constexpr size_t kMaxNotes = 20;  // messages per call: a file may hold any number of runs

}  // namespace

StreamFrames::Changes StreamFrames::take(const record::Played& played) {
  Changes taken;
  auto decoded = decoder_.decode(played.message);
  if (!decoded) {
    ++unusable_.malformed;
    return taken;
  }
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (receiver_ && description->epoch == receiver_->epoch) return taken;  // repeated description
    if (description->protocol_major != wire::kProtocolMajor) {
      ++unusable_.other_version;
      return taken;
    }
    receiver_.emplace(description->epoch, description->node_names.size());
    sim_time_ns_.reset();
    taken.began = true;
    return taken;
  }
  if (!receiver_) {
    ++unusable_.before_description;
    return taken;
  }
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded)) {
    const bool sound =
        frame->header.sim_time_ns > -kMaxSimTimeNs && frame->header.sim_time_ns < kMaxSimTimeNs;
    if (!sound) ++unusable_.distant;
    taken.frame = sound && receiver_->push(*frame);
  } else if (auto* edit = std::get_if<wire::SceneEdit>(&*decoded)) {
    taken.edited = true;
    taken.frame = receiver_->apply(std::move(*edit));
    (void)receiver_->take_edits();  // only the frames are used
  } else if (const auto* unknown = std::get_if<wire::UnknownEdit>(&*decoded)) {
    taken.edited = true;
    taken.frame = receiver_->apply(*unknown);
  } else if (std::holds_alternative<wire::Goodbye>(*decoded)) {
    receiver_.reset();
    taken.ended = true;
  }
  if (taken.frame) {
    taken.segment = !sim_time_ns_ || header().sim_time_ns < *sim_time_ns_;
    sim_time_ns_ = header().sim_time_ns;
  }
  return taken;
}

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
    const StreamFrames::Changes taken = frames_.take(played);
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

Result<RecordedStreams> RecordedStreams::open(const Open& open_recording, const Timeline& timeline,
                                              state::PoseState& poses) {
  RecordedStreams streams(poses);
  for (size_t i = 0; i < timeline.streams().size(); ++i) {
    auto playback = open_recording();
    if (!playback) return playback.error();
    if (playback->streams().size() != timeline.streams().size())
      return Error{wire::printable(playback->reader().name(), 4096) +
                   " was written to while it was read; render it when it is whole"};
    streams.streams_.push_back({StreamCursor(std::move(*playback), i, timeline), {}});
  }
  return streams;
}

void RecordedStreams::advance(int64_t line_ns) {
  while (Stream* stream = next_until(line_ns)) apply(*stream, stream->cursor.take());
  for (Stream& stream : streams_) {
    if (!stream.id) continue;
    const auto moment = stream.cursor.at(line_ns);
    if (moment && moment->changed) poses_.show_moment(*stream.id, moment->header, moment->poses);
  }
}

// Stream with the earliest effect; ties are resolved by recording order.
RecordedStreams::Stream* RecordedStreams::next_until(int64_t line_ns) {
  Stream* first = nullptr;
  std::tuple<int64_t, uint64_t> first_at;
  for (Stream& stream : streams_) {
    const StreamCursor::Effect* const effect = stream.cursor.peek();
    if (!effect || effect->at_ns > line_ns) continue;
    const std::tuple at{effect->at_ns, effect->log_time_ns};
    if (first && first_at <= at) continue;
    first = &stream;
    first_at = at;
  }
  return first;
}

void RecordedStreams::apply(Stream& stream, const StreamCursor::Effect& effect) {
  using Kind = StreamCursor::Effect::Kind;
  if (effect.kind == Kind::end) {
    if (stream.id) poses_.remove_stream(*stream.id);
    stream.id.reset();
    return;
  }
  if (effect.kind == Kind::frame) return;
  auto decoded = decoder_.decode(effect.message);  // decoded successfully before
  if (!decoded) return;
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    begin(stream, *description);
  } else if (auto* edit = std::get_if<wire::SceneEdit>(&*decoded)) {
    if (stream.id) poses_.apply(*stream.id, std::move(*edit));
  } else if (const auto* unknown = std::get_if<wire::UnknownEdit>(&*decoded)) {
    if (stream.id) poses_.apply(*stream.id, *unknown);
  }
}

void RecordedStreams::begin(Stream& stream, const wire::StreamDescription& description) {
  if (stream.id) poses_.remove_stream(*stream.id);
  stream.id = poses_.add_stream(description);
  if (notes_.size() >= kMaxNotes) return;
  const state::Stream& bound = poses_.streams()[*stream.id];
  const auto list = [&](const state::IndexSet& names) {
    std::string text = wire::printable(poses_.names_at(*stream.id, names, kMaxNameBytes)[0]);
    if (names.size() > 1) text += " and " + std::to_string(names.size() - 1) + " more";
    return text;
  };
  std::string note = "stream \"" + wire::printable(description.adapter_name) + "\" with " +
                     std::to_string(description.node_names.size()) + " nodes";
  if (!bound.unmatched_names.empty()) note += "; no scene node is called " + list(bound.unmatched_names);
  if (!bound.conflicting_names.empty()) note += "; another stream drives " + list(bound.conflicting_names);
  notes_.push_back(std::move(note));
}

uint64_t RecordedStreams::left_out() const {
  uint64_t count = 0;
  for (const Stream& stream : streams_) count += stream.cursor.left_out();
  return count;
}

}  // namespace fire3dv::offline
