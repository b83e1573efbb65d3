// Stream-level reader of recordings: plays messages in recorded order from any time, preceded by the state in
// force then. Knows channel roles; does not decode poses.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/record/channels.h"
#include "protocol/record/mcap/reader.h"
#include "protocol/wire/decode.h"

namespace fire3dv::record {

struct Played {
  enum class Kind { description, edit, pose, goodbye };
  Kind kind = Kind::pose;
  size_t stream = 0;  // index into Playback::streams()
  uint64_t log_time_ns = 0;
  uint64_t edit_key = 0;               // edits: stable number of the node and property in this stream
  std::span<const std::byte> message;  // valid until the next call
};

class Playback {
 public:
  // Fails for a file without fire3dv streams.
  static Result<Playback> open(std::unique_ptr<Source> source, const ReadLimits& limits = {});

  struct Stream {
    std::string name;
    std::array<uint16_t, kRoles.size()> channels{};  // channel ids by role; 0: none
  };
  const std::vector<Stream>& streams() const { return streams_; }
  // Log times of the first and last message.
  uint64_t start_ns() const { return start_ns_; }
  uint64_t end_ns() const { return end_ns_; }
  Reader& reader() { return reader_; }
  const Reader& reader() const { return reader_; }

  // Seeks to a log time. next() then returns, with this time, each stream's description and edits in force,
  // in version order. The recorded messages from that time follow. Reads only chunks with descriptions or
  // edits, from the last one before that time that describes every stream. A seek to the start replays
  // everything as recorded.
  void seek(uint64_t log_time_ns);
  // Restarts at the first message, without state messages.
  void rewind();

  enum class Step { played, damaged, end };
  Step next(Played& played);
  const std::string& problem() const { return reader_.problem(); }
  // number of skipped messages: invalid messages, and edits without memory
  uint64_t refused() const { return refused_; }

 private:
  using EditName = std::pair<std::string, wire::Property>;
  // State of a stream at the current position.
  struct State {
    uint64_t epoch = 0, version = 0;
    size_t unknown_edits = 0;           // in this epoch
    std::map<EditName, uint64_t> keys;  // outlives epochs
    // Used only while seeking.
    Bytes description;
    std::map<uint64_t, std::pair<uint64_t, Bytes>> edits;  // by key: version, message
  };
  struct Queued {
    Played::Kind kind;
    size_t stream;
    uint64_t edit_key;
    Bytes message;
  };

  explicit Playback(Reader reader) : reader_(std::move(reader)) {}

  // Stream and role of a channel; null for foreign channels.
  const std::pair<size_t, Role>* find_channel(uint16_t channel) const;
  // Returns true if the message carries news, and describes it in `played`. Poses always do.
  bool take(size_t stream, Role role, std::span<const std::byte> message, Played& played);
  bool has_state_messages(const ChunkIndex& chunk) const;
  void store_edit_description(State& state, std::span<const std::byte> message);
  void drop_description(State& state);
  bool describes(size_t chunk, uint64_t until_ns, std::vector<bool>& described);
  void store_edit(State& state, uint64_t key, std::span<const std::byte> message);
  void gather_state(uint64_t from_ns, uint64_t until_ns);

  Reader reader_;
  wire::Decoder decoder_;
  std::vector<Stream> streams_;
  std::vector<State> states_;
  std::map<uint16_t, std::pair<size_t, Role>> channels_;
  uint64_t start_ns_ = 0, end_ns_ = 0;
  std::vector<Queued> queue_;  // state messages that precede playback
  size_t next_queued_ = 0;
  uint64_t queue_time_ns_ = 0;
  uint64_t refused_ = 0;
  uint64_t state_bytes_ = 0;  // bytes retained while seeking
  uint64_t key_bytes_ = 0;    // bytes of all edit names
};

// Log time of a stream's first frame at or after this simulated time. Binary search over the chunks, decoding
// one frame of each. If simulated time restarts within the file, the frame is from one of the runs. Moves the
// playback: call seek() afterwards.
std::optional<uint64_t> log_time_of(Playback& playback, size_t stream, int64_t sim_time_ns);

}  // namespace fire3dv::record
