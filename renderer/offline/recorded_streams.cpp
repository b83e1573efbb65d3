#include "renderer/offline/recorded_streams.h"

#include <algorithm>
#include <tuple>

#include "protocol/wire/check.h"

namespace fire3dv::offline {
namespace {

constexpr size_t kMaxNameBytes = 2048;  // room for one name
constexpr size_t kMaxNotes = 20;        // per call: a file may hold any number of runs

}  // namespace

Result<RecordedStreams> RecordedStreams::open(const Open& open_recording, const Timeline& timeline,
                                              state::PoseState& poses) {
  RecordedStreams streams(timeline, poses);
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
