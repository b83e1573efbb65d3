// Small recordings in memory with known messages.
#pragma once

#include <string>
#include <vector>

#include "protocol/record/playback.h"
#include "protocol/record/stream_log.h"
#include "protocol/wire/encode.h"

namespace fire3dv::record_test {

using record::Bytes;
using record::Playback;
using record::Played;

constexpr uint64_t kBegun_ns = 1'700'000'000'000'000'000;
constexpr uint64_t kMs = 1'000'000;

inline Bytes description(uint64_t epoch, const std::string& name = "arm", uint32_t nodes = 3) {
  wire::StreamDescription result;
  result.protocol_minor = 1;  // as in the files of recordings/, which stay unchanged
  result.epoch = epoch;
  result.adapter_name = name;
  for (uint32_t i = 0; i < nodes; ++i) result.node_names.push_back("link_" + std::to_string(i));
  result.nominal_rate_hz = 1000;
  result.clock = {"boot", 1000, static_cast<int64_t>(kBegun_ns), 1};
  return wire::encode(result);
}

inline Bytes frame(uint64_t epoch, uint64_t sequence, uint32_t nodes = 3) {
  std::vector<wire::Affine3x4> poses(nodes);
  for (uint32_t i = 0; i < nodes; ++i) poses[i].m[3] = static_cast<float>(sequence * 10 + i);
  wire::PoseFrameView view;
  view.header = {epoch, sequence, static_cast<int64_t>(sequence * kMs), 1000 + sequence * kMs, 0, 0};
  view.node_count = nodes;
  view.poses = poses;
  return wire::encode(view);
}

inline Bytes edit(uint64_t epoch, uint64_t version, const std::string& node, bool visible) {
  return wire::encode(wire::SceneEdit{epoch, version, node, wire::Property::visible, wire::Visible{visible}});
}

// A log into memory, one byte string per file.
struct MemoryLog {
  explicit MemoryLog(const record::LogOptions& options = {})
      : log(
            [this](uint32_t file) -> Result<std::unique_ptr<record::Sink>> {
              while (files.size() <= file) files.push_back(std::make_unique<Bytes>());
              return std::unique_ptr<record::Sink>(std::make_unique<record::MemorySink>(*files[file]));
            },
            {}, options) {}
  bool take(const Bytes& message, uint64_t at_ms, uint64_t peer = 1) {
    return log.take(peer, message, kBegun_ns + at_ms * kMs).ok();
  }

  std::vector<std::unique_ptr<Bytes>> files;
  record::StreamLog log;
};

inline std::unique_ptr<record::Source> source_of(const Bytes& file) {
  return std::make_unique<record::MemorySource>(file);
}

struct LoggedMessage {
  uint16_t channel;
  uint64_t log_time_ns;
  Bytes data;
  bool operator==(const LoggedMessage&) const = default;
};

// Returns every message from the reader's position on.
inline std::vector<LoggedMessage> all_messages(record::Reader& reader) {
  std::vector<LoggedMessage> result;
  record::Message message;
  for (;;) {
    const auto step = reader.next(message);
    if (step == record::Reader::Step::end) return result;
    if (step == record::Reader::Step::message)
      result.push_back(
          {message.channel_id, message.log_time_ns, Bytes(message.data.begin(), message.data.end())});
  }
}

// A recording of one stream with edits, in several chunks.
inline Bytes small_recording(record::Compression compression, uint64_t frames = 40,
                             size_t chunk_bytes = 2048) {
  record::LogOptions options;
  options.writer = {compression, chunk_bytes};
  MemoryLog memory(options);
  memory.take(description(7), 0);
  for (uint64_t i = 1; i <= frames; ++i) {
    if (i % 8 == 1) memory.take(edit(7, i, "link_" + std::to_string(i % 3), i % 2 == 0), i);
    memory.take(frame(7, i), i);
  }
  memory.take(wire::encode(wire::Goodbye{7}), frames + 1);
  (void)memory.log.finish();
  return *memory.files[0];
}

struct PlayedMessage {
  Played::Kind kind;
  size_t stream;
  uint64_t edit_key;
  Bytes message;
};

// Plays everything from the playback position on.
inline std::vector<PlayedMessage> played_from(Playback& playback) {
  std::vector<PlayedMessage> result;
  Played played;
  for (;;) {
    const auto step = playback.next(played);
    if (step == Playback::Step::end) return result;
    if (step == Playback::Step::played)
      result.push_back(
          {played.kind, played.stream, played.edit_key, Bytes(played.message.begin(), played.message.end())});
  }
}

inline record::LogOptions small_chunks(size_t bytes = 1500) {
  record::LogOptions options;
  options.writer.chunk_bytes = bytes;
  return options;
}

}  // namespace fire3dv::record_test
