#include "protocol/record/stream_log.h"

#include <algorithm>

namespace fire3dv::record {
namespace {

constexpr size_t kMaxStreams = 1024;  // live streams, and ended streams that are not reclaimed
// Readers reserve 16 MiB for the index of a file by default, mostly for chunks. New streams are recorded
// until their channels take a quarter of it.
constexpr uint64_t kMaxChannelBytes = uint64_t{4} << 20;
constexpr uint64_t kEditOverhead = 256;
constexpr uint64_t kCheckNameEveryNs = 1'000'000'000;
// A snapshot is repeated after this multiple of all snapshots' bytes has been written since. Snapshots
// therefore take at most a ninth of the file.
constexpr uint64_t kSnapshotShare = 8;

// Converts the publisher's monotonic clock to Unix time; falls back to the log time.
uint64_t unix_ns(const wire::ClockInfo& clock, uint64_t publish_time_ns, uint64_t log_time_ns) {
  const auto since_open_ns = static_cast<int64_t>(publish_time_ns - clock.monotonic_at_open_ns);
  int64_t result_ns = 0;
  if (clock.realtime_at_open_ns <= 0 ||
      __builtin_add_overflow(clock.realtime_at_open_ns, since_open_ns, &result_ns) || result_ns < 0)
    return log_time_ns;
  return static_cast<uint64_t>(result_ns);
}

// Counts without the messages that the disk did not take.
StreamSeen written(const StreamSeen& seen, const MessageCounts& lost) {
  StreamSeen result = seen;
  result.frames -= lost.frames;
  result.messages -= lost.messages;
  result.bytes -= lost.bytes;
  result.edits -= lost.edits;
  result.parts -= lost.parts;
  result.missing += lost.frames;
  return result;
}

}  // namespace

MessageCounts& MessageCounts::operator+=(const MessageCounts& other) {
  frames += other.frames;
  messages += other.messages;
  bytes += other.bytes;
  edits += other.edits;
  parts += other.parts;
  return *this;
}

StreamLog::StreamLog(MakeSink make_sink, OnFile on_file, const LogOptions& options)
    : make_sink_(std::move(make_sink)), on_file_(std::move(on_file)), options_(options) {}

StreamLog::Stream* StreamLog::stream_of(uint64_t peer) {
  const auto found = stream_of_peer_.find(peer);
  return found == stream_of_peer_.end() ? nullptr : streams_[found->second].get();
}

void StreamLog::end(Stream& stream) {
  if (std::exchange(stream.seen.live, false)) stream.ended_as = ++endings_;
  stream.seen.incomplete = stream.tally.incomplete(true);
}

// Drops the stream's description and edits, but not its counts. A returning stream is described again.
void StreamLog::drop_state(Stream& stream) {
  for (const auto& [key, edit] : stream.edits) edit_bytes_ -= edit.second.size() + kEditOverhead;
  for (const auto& [version, edit] : stream.unknown_edits) edit_bytes_ -= edit.size() + kEditOverhead;
  stream.edits.clear();
  stream.unknown_edits.clear();
  description_bytes_ -= stream.description.size();
  stream.description = Bytes();
  stream.snapshot_bytes = stream.version = stream.seen.epoch = 0;
}

bool StreamLog::evict_oldest_ended() {
  Stream* oldest = nullptr;
  for (const auto& stream : streams_)
    if (!stream->seen.live && !stream->description.empty() &&
        (oldest == nullptr || stream->ended_as < oldest->ended_as))
      oldest = stream.get();
  if (oldest == nullptr) return false;
  drop_state(*oldest);
  reclaimed_unconverted_ += oldest->foxglove.markers.left_out();
  oldest->foxglove.markers = {};
  oldest->foxglove.transforms = {};
  return true;
}

// Makes the peer the only owner of the stream: earlier peers no longer write to it or end it.
void StreamLog::leave(uint64_t peer, size_t stream) {
  std::erase_if(stream_of_peer_, [&](const auto& entry) { return entry.second == stream; });
  stream_of_peer_[peer] = stream;
}

// Takes over the stream with this epoch. An epoch identifies one run of one stream, so its previous
// connection was lost silently.
StreamLog::Stream* StreamLog::take_over(uint64_t peer, uint64_t epoch) {
  for (size_t i = 0; i < streams_.size(); ++i) {
    if (!streams_[i]->seen.live || streams_[i]->seen.epoch != epoch) continue;
    leave(peer, i);
    return streams_[i].get();
  }
  return nullptr;
}

std::optional<size_t> StreamLog::free_slot() {
  if (streams_.size() < kMaxStreams) {
    streams_.push_back(nullptr);
    return streams_.size() - 1;
  }
  std::optional<size_t> oldest;
  for (size_t i = 0; i < streams_.size(); ++i)
    if (!streams_[i]->seen.live && (!oldest || streams_[i]->ended_as < streams_[*oldest]->ended_as))
      oldest = i;
  if (!oldest) return {};
  Stream& stream = *streams_[*oldest];
  drop_state(stream);
  std::erase_if(stream_of_peer_, [&](const auto& entry) { return entry.second == *oldest; });
  ++reclaimed_streams_;
  const StreamSeen in_files = written(stream.seen, stream.lost);
  reclaimed_.frames += in_files.frames;
  reclaimed_missing_ += in_files.missing + in_files.incomplete;
  reclaimed_in_chunk_ += stream.in_chunk;
  reclaimed_unconverted_ += stream.foxglove.markers.left_out();
  return oldest;
}

// A name with channels in the file needs no more.
bool StreamLog::can_add_channels(const std::string& name) {
  if (channels_.bytes() < kMaxChannelBytes || channels_.has_stream(name)) return true;
  file_is_full_ = options_.split_bytes != 0 || options_.split_ns != 0;
  return file_is_full_;
}

std::optional<size_t> StreamLog::new_stream(const std::string& name) {
  if (!can_add_channels(name)) return {};
  const auto slot = free_slot();
  if (!slot) return {};
  streams_[*slot] = std::make_unique<Stream>();
  streams_[*slot]->seen.name = name;
  return slot;
}

void StreamLog::refuse_stream(uint64_t peer) {
  ++refused_;
  if (unrecorded_peers_.insert(peer).second) ++unrecorded_streams_;
}

Result<void> StreamLog::take(uint64_t peer, std::span<const std::byte> message, uint64_t log_time_ns) {
  now_ns_ = std::max(now_ns_, log_time_ns);  // files are in time order, even if a clock steps back
  const auto decoded = decoder_.decode(message);
  if (!decoded) {
    ++refused_;
    return {};
  }
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded))
    return take_description(peer, *description, message);
  Stream* const stream = stream_of(peer);
  const auto belongs = [&](uint64_t epoch) {
    if (stream != nullptr && stream->seen.epoch == epoch && !stream->description.empty()) return true;
    ++refused_;
    return false;
  };
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded))
    return belongs(frame->header.epoch) ? take_frame(*stream, *frame, message) : Result<void>();
  if (const auto* edit = std::get_if<wire::SceneEdit>(&*decoded))
    return belongs(edit->epoch) ? take_edit(*stream, edit, edit->version, message) : Result<void>();
  if (const auto* edit = std::get_if<wire::UnknownEdit>(&*decoded))
    return belongs(edit->epoch) ? take_edit(*stream, nullptr, edit->version, message) : Result<void>();
  if (const auto* goodbye = std::get_if<wire::Goodbye>(&*decoded)) {
    if (!belongs(goodbye->epoch)) return {};
    auto good = write(*stream, Role::control, now_ns_, 0, message);
    if (good && options_.foxglove) {
      FoxgloveLog::Stream& foxglove = stream->foxglove;
      good = foxglove_.write_markers(foxglove_output(), foxglove, stream->seen.name,
                                     foxglove.markers.clear_all(now_ns_));
    }
    end(*stream);
    return good;
  }
  return {};  // pings and similar messages concern the link only
}

Result<void> StreamLog::take_description(uint64_t peer, const wire::StreamDescription& description,
                                         std::span<const std::byte> message) {
  if (description.protocol_major != wire::kProtocolMajor) {
    ++refused_;
    return {};
  }
  Stream* stream = stream_of(peer);
  if (stream == nullptr) stream = take_over(peer, description.epoch);
  if (stream == nullptr) {
    const std::string base = description.adapter_name.empty() ? "stream" : description.adapter_name;
    std::string name = base;
    for (size_t number = 2; stream == nullptr; ++number) {
      const auto known = std::find_if(streams_.begin(), streams_.end(),
                                      [&](const auto& each) { return each->seen.name == name; });
      if (known == streams_.end()) {
        const auto slot = new_stream(name);
        if (!slot) {
          refuse_stream(peer);
          return {};
        }
        stream = streams_[*slot].get();
        leave(peer, *slot);
      } else if (!(*known)->seen.live) {
        stream = known->get();
        leave(peer, static_cast<size_t>(known - streams_.begin()));
      }
      name = base + "_" + std::to_string(number);
    }
  }
  stream->seen.live = true;
  // The link repeats descriptions for reliability; a publisher that reconnected continues its stream.
  if (stream->seen.epoch == description.epoch && std::ranges::equal(stream->description, message)) return {};
  drop_state(*stream);
  while (description_bytes_ + message.size() > options_.max_snapshot_bytes)
    if (!evict_oldest_ended()) {
      refuse_stream(peer);
      return {};
    }
  unrecorded_peers_.erase(peer);
  description_bytes_ += message.size();
  stream->seen.epoch = description.epoch;
  stream->seen.sequence = 0;
  stream->seen.nodes = static_cast<uint32_t>(description.node_names.size());
  stream->tally.begin();
  stream->clock = description.clock;
  std::vector<FoxgloveMessage> cleared;
  if (options_.foxglove) {
    cleared = stream->foxglove.markers.clear_all(now_ns_);  // those of the last run
    stream->foxglove.markers.describe(description);
    stream->foxglove.transforms.describe(description);
  }
  stream->description.assign(message.begin(), message.end());
  stream->snapshot_bytes = message.size();
  if (auto good = write(*stream, Role::control, now_ns_, 0, message, true); !good) return good;
  return foxglove_.write_markers(foxglove_output(), stream->foxglove, stream->seen.name, cleared);
}

Result<void> StreamLog::take_frame(Stream& stream, const wire::PoseFrameView& frame,
                                   std::span<const std::byte> message) {
  StreamSeen& seen = stream.seen;
  const uint64_t parts_before = seen.parts;
  stream.next.frames = stream.tally.take(frame);
  seen.sequence = stream.tally.newest();
  seen.frames = stream.tally.counts().frames;
  seen.parts = stream.tally.counts().parts;
  stream.next.parts = seen.parts - parts_before;
  seen.missing = stream.tally.counts().missing;
  seen.late = stream.tally.counts().late;
  seen.incomplete = stream.tally.incomplete(false);
  const uint64_t published_ns = unix_ns(stream.clock, frame.header.publish_time_ns, now_ns_);
  const bool is_new = stream.next.frames != 0;
  auto good = write(stream, Role::poses, published_ns, static_cast<uint32_t>(frame.header.sequence), message);
  if (!good || !options_.foxglove) return good;
  good = foxglove_.write_transforms(foxglove_output(), stream.foxglove, seen.name, frame, published_ns);
  if (!good || !is_new) return good;
  return foxglove_.write_markers(foxglove_output(), stream.foxglove, seen.name,
                                 stream.foxglove.markers.advance(frame.header.sim_time_ns, now_ns_));
}

// Returns false if there is no memory: the edit is then missing from snapshots.
bool StreamLog::reserve_edit_memory(uint64_t bytes) {
  const auto is_full = [&] { return edit_bytes_ + bytes + kEditOverhead > options_.max_snapshot_bytes; };
  while (is_full() && evict_oldest_ended()) {
  }
  if (is_full()) {
    ++dropped_edits_;
    return false;
  }
  edit_bytes_ += bytes + kEditOverhead;
  return true;
}

Result<void> StreamLog::take_edit(Stream& stream, const wire::SceneEdit* edit, uint64_t version,
                                  std::span<const std::byte> message) {
  if (version <= stream.version) return {};  // repeated by the link
  stream.version = version;
  ++stream.seen.edits;
  stream.next.edits = 1;
  if (edit != nullptr && stream.seen.live) {
    const auto key = std::make_pair(edit->node, edit->property);
    if (const auto known = stream.edits.find(key); known != stream.edits.end()) {
      const uint64_t bytes = known->second.second.size();
      edit_bytes_ -= bytes + kEditOverhead;
      stream.snapshot_bytes -= bytes;
      stream.edits.erase(known);
    }
    if (reserve_edit_memory(message.size())) {
      stream.edits[key] = {version, Bytes(message.begin(), message.end())};
      stream.snapshot_bytes += message.size();
    }
  } else if (stream.seen.live) {
    if (stream.unknown_edits.size() == wire::kMaxSceneEdits) {
      ++dropped_edits_;
    } else if (reserve_edit_memory(message.size())) {
      stream.unknown_edits[version].assign(message.begin(), message.end());
      stream.snapshot_bytes += message.size();
    }
  }
  auto good = write(stream, Role::control, now_ns_, static_cast<uint32_t>(version), message);
  if (!good || !options_.foxglove || edit == nullptr || edit->property != wire::Property::marker) return good;
  return foxglove_.write_marker(foxglove_output(), stream.foxglove, stream.seen.name, *edit);
}

void StreamLog::end_peer(uint64_t peer) {
  if (Stream* const stream = stream_of(peer)) end(*stream);
  stream_of_peer_.erase(peer);
  unrecorded_peers_.erase(peer);
}

Result<void> StreamLog::tick(uint64_t now_ns) {
  if (!writer_) return {};
  check_name(now_ns);
  Result<void> good;
  const bool is_flushed = writer_->chunk_is_empty() && writer_->file_bytes() == flushed_bytes_;
  if (is_flushed) {
    flushed_ns_ = std::max(flushed_ns_, now_ns);  // the flush interval starts with the next message
  } else if (options_.flush_ns != 0 && now_ns >= flushed_ns_ + options_.flush_ns) {
    good = writer_->flush();
    flushed_bytes_ = writer_->file_bytes();
    flushed_ns_ = now_ns;
  } else if (!writer_->chunk_is_empty() && now_ns >= chunk_begun_ns_ + options_.chunk_ns) {
    good = writer_->end_chunk();
  }
  account_closed_chunk();
  return good;
}

void StreamLog::check_name(uint64_t now_ns) {
  if (name_fault_ || now_ns < name_checked_ns_ + kCheckNameEveryNs) return;
  name_checked_ns_ = now_ns;
  if (const Result<void> named = writer_->check_name(); !named) name_fault_ = named.error().message;
}

// Called after any operation that may have ended a chunk. Its messages are then in the file or lost.
void StreamLog::account_closed_chunk() {
  if (!writer_->chunk_is_empty()) return;
  const uint64_t lost = file_messages_ - writer_->messages() - file_lost_messages_;
  file_lost_messages_ += lost;
  for (auto& stream : streams_) {
    const MessageCounts counts = std::exchange(stream->in_chunk, {});
    if (lost != 0) stream->lost += counts;
  }
  const MessageCounts counts = std::exchange(reclaimed_in_chunk_, {});
  if (lost != 0) reclaimed_.frames -= counts.frames;
}

Result<void> StreamLog::open_file() {
  if (open_failure_) return *open_failure_;
  auto sink = make_sink_(files_);
  if (!sink) return *(open_failure_ = sink.error());
  auto writer = Writer::open(std::move(*sink), options_.writer);
  if (!writer) return *(open_failure_ = writer.error());
  ++files_;
  writer_.emplace(std::move(*writer));
  file_begun_ns_ = flushed_ns_ = now_ns_;
  flushed_bytes_ = 0;
  foxglove_.begin_file();
  file_is_full_ = false;
  for (auto& stream : streams_) {
    stream->channels = {};
    stream->foxglove.transforms_channel = stream->foxglove.markers_channel = 0;
    stream->in_current_file = false;
  }
  channels_.begin(*writer_);
  const auto schema = channels_.schema(kMessageSchema, message_schema());
  if (!schema) return schema.error();
  schema_ = *schema;
  if (on_file_)
    if (auto good = on_file_(*writer_, now_ns_); !good) return good;
  return options_.foxglove && !options_.models.empty() ? write_models() : Result<void>();
}

Result<void> StreamLog::close_file() {
  if (!writer_) return {};
  const auto good = writer_->finish();
  account_closed_chunk();
  lost_messages_ += std::exchange(file_lost_messages_, 0);
  file_messages_ = 0;
  closed_bytes_ += writer_->file_bytes();
  writer_.reset();
  return good;
}

Result<void> StreamLog::finish() {
  // An empty recording is a valid file.
  if (!writer_ && files_ == 0)
    if (auto good = open_file(); !good) return good;
  return close_file();
}

Result<void> StreamLog::write(Stream& stream, Role role, uint64_t publish_time_ns, uint32_t sequence,
                              std::span<const std::byte> message, bool describes) {
  ++stream.seen.messages;
  stream.seen.bytes += message.size();
  MessageCounts counts = std::exchange(stream.next, {});
  counts.messages = 1;
  counts.bytes = message.size();
  if (auto good = prepare_write(stream, describes); !good) {
    stream.lost += counts;
    return good;
  }
  stream.in_chunk += counts;
  return write_plain(stream, role, publish_time_ns, sequence, message);
}

// Starts files and chunks and writes the snapshots that precede the stream's next message.
Result<void> StreamLog::prepare_write(Stream& stream, bool describes) {
  const bool full =
      writer_ && (file_is_full_ ||
                  (options_.split_bytes != 0 &&
                   writer_->file_bytes() + writer_->chunk_bytes() >= initial_bytes_ + options_.split_bytes) ||
                  (options_.split_ns != 0 && now_ns_ - file_begun_ns_ >= options_.split_ns));
  const bool begins = full || !writer_;
  if (begins) {
    if (auto good = close_file(); !good) return good;
    if (auto good = open_file(); !good) return good;
  }
  if (auto good = tick(now_ns_); !good) return good;
  if (writer_->chunk_is_empty() || !chunk_has_snapshots_)
    if (auto good = write_snapshots(describes ? &stream : nullptr); !good) return good;
  chunk_has_snapshots_ = true;
  if (describes) {
    stream.in_current_file = true;
    stream.described_at_bytes = message_bytes_;
  } else if (!stream.in_current_file) {
    // The stream was absent when this file began and returned unchanged.
    if (auto good = write_snapshot(stream); !good) return good;
  }
  if (begins) initial_bytes_ = writer_->file_bytes() + writer_->chunk_bytes();
  return {};
}

Result<void> StreamLog::write_snapshots(const Stream* described) {
  uint64_t snapshot_bytes = 0;
  for (const auto& stream : streams_)
    if (stream->seen.live) snapshot_bytes += stream->snapshot_bytes;
  for (auto& stream : streams_) {
    if (!stream->seen.live || stream->description.empty() || stream.get() == described) continue;
    const bool due = !stream->in_current_file ||
                     message_bytes_ - stream->described_at_bytes >= kSnapshotShare * snapshot_bytes;
    if (!due) continue;
    if (auto good = write_snapshot(*stream); !good) return good;
  }
  return {};
}

Result<void> StreamLog::write_snapshot(Stream& stream) {
  const bool begins = !std::exchange(stream.in_current_file, true);
  if (auto good = write_plain(stream, Role::snapshot, now_ns_, 0, stream.description); !good) return good;
  std::vector<std::pair<uint64_t, const Bytes*>> edits;
  for (const auto& [key, edit] : stream.edits) edits.emplace_back(edit.first, &edit.second);
  for (const auto& [version, edit] : stream.unknown_edits) edits.emplace_back(version, &edit);
  std::sort(edits.begin(), edits.end());
  for (const auto& [version, edit] : edits)
    if (auto good = write_plain(stream, Role::snapshot, now_ns_, static_cast<uint32_t>(version), *edit);
        !good)
      return good;
  stream.described_at_bytes = message_bytes_;
  return begins && options_.foxglove ? write_all_markers(stream) : Result<void>();
}

Result<void> StreamLog::write_plain(Stream& stream, Role role, uint64_t publish_time_ns, uint32_t sequence,
                                    std::span<const std::byte> message) {
  const auto which = static_cast<size_t>(role);
  uint16_t& channel = stream.channels[which];
  if (channel == 0) {
    const std::string& name = stream.seen.name;
    const auto known = channels_.channel(name, role_name(role), schema_,
                                         {{kRoleKey, std::string(role_name(role))}, {kStreamKey, name}});
    if (!known) return known.error();
    channel = *known;
  }
  if (writer_->chunk_is_empty()) chunk_begun_ns_ = now_ns_;
  if (role != Role::snapshot) message_bytes_ += message.size();
  ++file_messages_;
  auto good = writer_->write({channel, sequence, now_ns_, publish_time_ns, message});
  account_closed_chunk();
  return good;
}

// At the start of a file.
Result<void> StreamLog::write_models() {
  const auto schema = channels_.schema(kSceneUpdateSchema, scene_update_schema());
  if (!schema) return schema.error();
  const auto channel = writer_->add_channel(*schema, "/scene", std::string(kEncoding), {});
  if (!channel) return channel.error();
  const Bytes message = scene_update(options_.models, now_ns_);
  chunk_begun_ns_ = now_ns_;
  ++file_messages_;
  if (auto good = writer_->write({*channel, 0, now_ns_, now_ns_, message}); !good) return good;
  return writer_->end_chunk();  // large messages get a chunk of their own
}

FoxgloveLog::Output StreamLog::foxglove_output() {
  return {channels_, now_ns_,
          [this](uint16_t channel, uint32_t sequence, uint64_t publish_time_ns,
                 std::span<const std::byte> message) -> Result<void> {
            if (writer_->chunk_is_empty()) {
              chunk_begun_ns_ = now_ns_;
              chunk_has_snapshots_ = false;
            }
            ++file_messages_;
            auto good = writer_->write({channel, sequence, now_ns_, publish_time_ns, message});
            account_closed_chunk();
            return good;
          }};
}

// At the start of a file, whose viewers know nothing of earlier ones.
Result<void> StreamLog::write_all_markers(Stream& stream) {
  for (const auto& [key, stored] : stream.edits) {
    if (key.second != wire::Property::marker) continue;
    const auto decoded = snapshot_decoder_.decode(stored.second);
    const auto* edit = decoded ? std::get_if<wire::SceneEdit>(&*decoded) : nullptr;
    if (edit == nullptr || std::holds_alternative<wire::Cleared>(edit->value)) continue;
    if (auto good = foxglove_.write_marker(foxglove_output(), stream.foxglove, stream.seen.name, *edit);
        !good)
      return good;
  }
  return {};
}

uint64_t StreamLog::unconverted_markers() const {
  uint64_t count = reclaimed_unconverted_;
  for (const auto& stream : streams_) count += stream->foxglove.markers.left_out();
  return count;
}

std::vector<StreamSeen> StreamLog::streams() const {
  std::vector<StreamSeen> result;
  for (const auto& stream : streams_) result.push_back(written(stream->seen, stream->lost));
  return result;
}

}  // namespace fire3dv::record
