#include "protocol/record/sim_time.h"

#include <algorithm>

namespace fire3dv::record {
namespace {

struct FrameAt {
  int64_t sim_time_ns;
  uint64_t log_time_ns;
};

bool may_have(const ChunkIndex& chunk, uint16_t channel) {
  return chunk.message_indexes.empty() || std::ranges::any_of(chunk.message_indexes, [&](const auto& entry) {
           return entry.first == channel;
         });
}

// First frame of the channel in the chunk at or after a simulated time.
std::optional<FrameAt> frame_in(Reader& reader, wire::Decoder& decoder, size_t chunk, uint16_t channel,
                                int64_t from_sim_ns) {
  if (!may_have(reader.index().chunks[chunk], channel)) return {};
  reader.seek_chunk(chunk, true);
  Message message;
  for (;;) {
    const Reader::Step step = reader.next(message);
    if (step == Reader::Step::end) return {};
    if (step != Reader::Step::message || message.channel_id != channel) continue;
    const auto decoded = decoder.decode(message.data);
    const auto* frame = decoded ? std::get_if<wire::PoseFrameView>(&*decoded) : nullptr;
    if (frame != nullptr && frame->header.sim_time_ns >= from_sim_ns)
      return FrameAt{frame->header.sim_time_ns, message.log_time_ns};
  }
}

}  // namespace

std::optional<uint64_t> log_time_of(Playback& playback, size_t stream, int64_t sim_time_ns) {
  Reader& reader = playback.reader();
  wire::Decoder decoder;
  const uint16_t channel = playback.streams()[stream].channels[static_cast<size_t>(Role::poses)];
  if (channel == 0) return {};
  const size_t chunks = reader.index().chunks.size();
  // Finds the first chunk in [chunk, until) with a pose frame of the channel.
  const auto first_frame = [&](size_t& chunk, size_t until) {
    std::optional<FrameAt> found;
    while (chunk < until && !(found = frame_in(reader, decoder, chunk, channel, INT64_MIN))) ++chunk;
    return found;
  };
  // Invariant: chunks before `low` begin before sim_time_ns; chunks from `high` on begin at or after it.
  size_t low = 0, high = chunks;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    size_t chunk = middle;
    const auto frame = first_frame(chunk, high);
    if (!frame || frame->sim_time_ns >= sim_time_ns)
      high = middle;
    else
      low = chunk + 1;
  }
  // The frame is in the last chunk that begins before it, or it is the first frame of the next chunk.
  for (size_t chunk = low == 0 ? 0 : low - 1; chunk < chunks; ++chunk)
    if (const auto found = frame_in(reader, decoder, chunk, channel, sim_time_ns)) return found->log_time_ns;
  return {};
}

}  // namespace fire3dv::record
