#include "protocol/record/playback.h"

#include <algorithm>
#include <string_view>

#include "protocol/wire/check.h"
#include "protocol/wire/limits.h"

namespace fire3dv::record {

namespace {

constexpr size_t kMaxPlayedStreams = 8192;  // a recorder stops adding streams when their channels take 4 MiB
constexpr uint64_t kEntryOverhead = 128;

}  // namespace

Result<Playback> Playback::open(std::unique_ptr<Source> source, const ReadLimits& limits) {
  auto reader = Reader::open(std::move(source), limits);
  if (!reader) return reader.error();
  Playback playback(std::move(*reader));
  const FileIndex& index = playback.reader_.index();
  std::map<std::string_view, size_t> stream_of_name;
  for (const auto& [id, channel] : index.channels) {
    const auto role = channel.metadata.find(kRoleKey);
    const auto name = channel.metadata.find(kStreamKey);
    if (role == channel.metadata.end() || name == channel.metadata.end() ||
        channel.message_encoding != kEncoding)
      continue;
    const auto known_role =
        std::ranges::find_if(kRoles, [&](Role each) { return role_name(each) == role->second; });
    if (known_role == kRoles.end()) continue;
    const auto known_stream = stream_of_name.find(name->second);
    if (known_stream == stream_of_name.end() && playback.streams_.size() == kMaxPlayedStreams) continue;
    const size_t stream =
        known_stream == stream_of_name.end() ? playback.streams_.size() : known_stream->second;
    if (stream == playback.streams_.size()) {
      playback.streams_.push_back({name->second, {}});
      stream_of_name[name->second] = stream;  // view into the index, which does not move
    }
    playback.streams_[stream].channels[static_cast<size_t>(*known_role)] = id;
    playback.channels_[id] = {stream, *known_role};
  }
  if (playback.streams_.empty())
    return Error{wire::printable(playback.reader_.name(), 4096) + " holds no stream of this protocol" +
                 (index.damage.empty() ? "; record one with fire3dv-record, or draw the states of another "
                                         "program by fire3dv relabel FILE SCENE"
                                       : ": " + index.damage)};
  playback.states_.resize(playback.streams_.size());
  for (const ChunkIndex& chunk : index.chunks) {
    if (playback.end_ns_ == 0 || chunk.start_ns < playback.start_ns_) playback.start_ns_ = chunk.start_ns;
    playback.end_ns_ = std::max(playback.end_ns_, chunk.end_ns);
  }
  return playback;
}

const std::pair<size_t, Role>* Playback::find_channel(uint16_t channel) const {
  const auto found = channels_.find(channel);
  return found == channels_.end() ? nullptr : &found->second;
}

// Skips a snapshot of known state, unless the file begins with it or the original message is damaged.
bool Playback::take(size_t stream, Role role, std::span<const std::byte> message, Played& played) {
  State& state = states_[stream];
  played.stream = stream;
  played.message = message;
  played.edit_key = 0;
  if (role == Role::poses) {
    played.kind = Played::Kind::pose;
    return true;
  }
  const auto decoded = decoder_.decode(message);
  if (!decoded) {
    ++refused_;
    return false;
  }
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (role == Role::snapshot && description->epoch == state.epoch) return false;
    if (state.epoch != description->epoch) state.version = state.unknown_edits = 0;
    state.epoch = description->epoch;
    for (const auto& [key, edit] : state.edits) state_bytes_ -= edit.second.size() + kEntryOverhead;
    state.edits.clear();
    played.kind = Played::Kind::description;
    return true;
  }
  if (const auto* edit = std::get_if<wire::SceneEdit>(&*decoded)) {
    if (edit->epoch != state.epoch || edit->version <= state.version) return false;
    const bool has_key = state.keys.contains({edit->node, edit->property});
    // Names may use at most half of the memory: their values need the rest.
    const uint64_t key_bytes = has_key ? 0 : edit->node.size() + kEntryOverhead;
    if (!has_key && (state.keys.size() == wire::kMaxSceneEdits ||
                     key_bytes_ + key_bytes > reader_.limits().max_state_bytes() / 2)) {
      ++refused_;
      return false;
    }
    key_bytes_ += key_bytes;
    state.version = edit->version;
    played.kind = Played::Kind::edit;
    const uint64_t fresh = state.keys.size() + 1;
    played.edit_key = state.keys.try_emplace({edit->node, edit->property}, fresh).first->second;
    return true;
  }
  if (const auto* edit = std::get_if<wire::UnknownEdit>(&*decoded)) {
    if (edit->epoch != state.epoch || edit->version <= state.version) return false;
    if (state.unknown_edits == wire::kMaxSceneEdits) {
      ++refused_;
      return false;
    }
    ++state.unknown_edits;
    state.version = edit->version;
    played.kind = Played::Kind::edit;
    // The replaced edit is unknown, so this edit gets its own key.
    played.edit_key = UINT64_MAX - edit->version;
    return true;
  }
  played.kind = Played::Kind::goodbye;
  const auto* goodbye = std::get_if<wire::Goodbye>(&*decoded);
  return goodbye != nullptr && goodbye->epoch == state.epoch;
}

void Playback::rewind() {
  for (State& state : states_) state.epoch = state.version = state.unknown_edits = 0;
  state_bytes_ = 0;
  queue_.clear();
  next_queued_ = 0;
  reader_.rewind();
}

bool Playback::has_state_messages(const ChunkIndex& chunk) const {
  if (chunk.message_indexes.empty()) return true;  // the chunk has no message index
  return std::ranges::any_of(chunk.message_indexes, [&](const auto& index) {
    const auto* channel = find_channel(index.first);
    return channel != nullptr && channel->second != Role::poses;
  });
}

// Marks the streams with a description in this chunk before until_ns. Returns false if there is none.
bool Playback::describes(size_t chunk, uint64_t until_ns, std::vector<bool>& described) {
  bool any = false;
  reader_.seek_chunk(chunk);
  Message message;
  for (;;) {
    const Reader::Step step = reader_.next(message);
    if (step == Reader::Step::end) break;
    const auto* channel = step == Reader::Step::message ? find_channel(message.channel_id) : nullptr;
    if (channel == nullptr || channel->second == Role::poses || message.log_time_ns >= until_ns) continue;
    const auto decoded = decoder_.decode(message.data);
    if (!decoded || !std::holds_alternative<wire::StreamDescription>(*decoded)) continue;
    described[channel->first] = any = true;
  }
  return any;
}

void Playback::store_edit(State& state, uint64_t key, std::span<const std::byte> message) {
  if (const auto known = state.edits.find(key); known != state.edits.end()) {
    state_bytes_ -= known->second.second.size() + kEntryOverhead;
    state.edits.erase(known);
  }
  const uint64_t bytes = message.size() + kEntryOverhead;
  if (key_bytes_ + state_bytes_ + bytes > reader_.limits().max_state_bytes()) {
    ++refused_;
    return;
  }
  state_bytes_ += bytes;
  state.edits[key] = {state.version, Bytes(message.begin(), message.end())};
}

// Without memory for its description a stream is absent until its next description.
void Playback::store_edit_description(State& state, std::span<const std::byte> message) {
  drop_description(state);
  if (key_bytes_ + state_bytes_ + message.size() > reader_.limits().max_state_bytes()) {
    ++refused_;
    return;
  }
  state_bytes_ += message.size();
  state.description.assign(message.begin(), message.end());
}

void Playback::drop_description(State& state) {
  state_bytes_ -= state.description.size();
  state.description = Bytes();
}

void Playback::gather_state(uint64_t from_ns, uint64_t until_ns) {
  reader_.seek(from_ns, [this, until_ns](const ChunkIndex& chunk) {
    return chunk.start_ns < until_ns && has_state_messages(chunk);
  });
  Message message;
  Played played;
  for (;;) {
    const Reader::Step step = reader_.next(message);
    if (step == Reader::Step::end) return;
    const auto* channel = step == Reader::Step::message ? find_channel(message.channel_id) : nullptr;
    if (channel == nullptr || channel->second == Role::poses || message.log_time_ns >= until_ns) continue;
    if (!take(channel->first, channel->second, message.data, played)) continue;
    State& state = states_[channel->first];
    if (played.kind == Played::Kind::description) store_edit_description(state, message.data);
    if (played.kind == Played::Kind::edit) store_edit(state, played.edit_key, message.data);
    if (played.kind == Played::Kind::goodbye) drop_description(state);  // the stream has ended
  }
}

void Playback::seek(uint64_t log_time_ns) {
  rewind();
  const auto& chunks = reader_.index().chunks;
  std::vector<bool> described(streams_.size(), false);
  uint64_t from_ns = log_time_ns;
  for (size_t chunk = chunks.size(); chunk-- > 0;) {
    if (chunks[chunk].start_ns >= log_time_ns || !has_state_messages(chunks[chunk])) continue;
    if (!describes(chunk, log_time_ns, described)) continue;
    from_ns = std::min(from_ns, chunks[chunk].start_ns);
    if (std::ranges::all_of(described, [](bool one) { return one; })) break;
  }
  if (from_ns < log_time_ns) gather_state(from_ns, log_time_ns);
  queue_time_ns_ = log_time_ns;
  for (size_t stream = 0; stream < states_.size(); ++stream) {
    State& state = states_[stream];
    if (!state.description.empty()) {
      queue_.push_back({Played::Kind::description, stream, 0, std::move(state.description)});
      std::vector<std::pair<uint64_t, uint64_t>> order;  // version, key
      for (const auto& [key, edit] : state.edits) order.emplace_back(edit.first, key);
      std::sort(order.begin(), order.end());
      for (const auto& [version, key] : order)
        queue_.push_back({Played::Kind::edit, stream, key, std::move(state.edits[key].second)});
    }
    state.description.clear();
    state.edits.clear();
  }
  reader_.seek(log_time_ns);
}

Playback::Step Playback::next(Played& played) {
  if (next_queued_ < queue_.size()) {
    const Queued& queued = queue_[next_queued_++];
    played = {queued.kind, queued.stream, queue_time_ns_, queued.edit_key, queued.message};
    return Step::played;
  }
  Message message;
  for (;;) {
    const Reader::Step step = reader_.next(message);
    if (step == Reader::Step::end) return Step::end;
    if (step == Reader::Step::damaged) return Step::damaged;
    const auto* channel = find_channel(message.channel_id);
    if (channel == nullptr || !take(channel->first, channel->second, message.data, played)) continue;
    played.log_time_ns = message.log_time_ns;
    return Step::played;
  }
}

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
  reader.seek_chunk(chunk);
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
