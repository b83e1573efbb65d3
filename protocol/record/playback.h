// The streams of a recording, as they came: from any moment on, with what has to be known before it. Knows
// the roles of channels; does not look into poses.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "protocol/record/reader.h"
#include "protocol/record/stream_names.h"
#include "protocol/wire/decode.h"

namespace fire3dv::record {

struct Played {
  enum class Kind { description, edit, pose, goodbye };
  Kind kind = Kind::pose;
  size_t stream = 0;  // of Playback::streams()
  uint64_t log_time_ns = 0;
  uint64_t edit_key = 0;  // edits: a number for each node and property of this stream, the same each time
  std::span<const std::byte> message;  // valid until the next call
};

class Playback {
 public:
  // An error for a file without any stream of ours.
  static Result<Playback> open(std::unique_ptr<Source> source, const ReadLimits& limits = {});

  struct Stream {
    std::string name;
    std::array<uint16_t, kRoles.size()> channels{};  // 0: it has none of this role
  };
  const std::vector<Stream>& streams() const { return streams_; }
  // Log times of the first and the last message.
  uint64_t start_ns() const { return start_ns_; }
  uint64_t end_ns() const { return end_ns_; }
  Reader& reader() { return reader_; }
  const Reader& reader() const { return reader_; }

  // next() gives first, with this time, the description and the edits of each stream that were in force then,
  // in the order of their versions, and after that whatever came from then on. Looks only at chunks that have
  // descriptions or edits in them, from the last one before that time that says them all. To the start:
  // everything as it came.
  void seek(uint64_t log_time_ns);
  // Everything as it came, from the first message on.
  void rewind();

  enum class Step { played, damaged, end };
  Step next(Played& played);
  const std::string& problem() const { return reader_.problem(); }
  // Messages that are none of the protocol's, or edits that there is no memory for; they are passed over.
  uint64_t refused() const { return refused_; }

 private:
  using EditName = std::pair<std::string, wire::Property>;
  // What is in force at the point that was reached.
  struct State {
    uint64_t epoch = 0, version = 0;
    size_t unknown_edits = 0;           // of this epoch
    std::map<EditName, uint64_t> keys;  // outlives epochs
    // Only while seeking.
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

  // Where a message of a channel belongs to; nothing for channels that are not ours.
  const std::pair<size_t, Role>* place_of(uint16_t channel) const;
  // Whether it says something new, and what. Poses always do.
  bool take(size_t stream, Role role, std::span<const std::byte> message, Played& played);
  bool has_state_messages(const ChunkIndex& chunk) const;
  void keep_description(State& state, std::span<const std::byte> message);
  void forget_description(State& state);
  bool describes(size_t chunk, uint64_t until_ns, std::vector<bool>& described);
  void keep(State& state, uint64_t key, std::span<const std::byte> message);
  void gather_state(size_t from_chunk, uint64_t until_ns);

  Reader reader_;
  wire::Decoder decoder_;
  std::vector<Stream> streams_;
  std::vector<State> states_;
  std::map<uint16_t, std::pair<size_t, Role>> places_;
  uint64_t start_ns_ = 0, end_ns_ = 0;
  std::vector<Queued> queue_;  // what has to be known first
  size_t next_queued_ = 0;
  uint64_t queue_time_ns_ = 0;
  uint64_t refused_ = 0;
  uint64_t state_bytes_ = 0;  // that seeking keeps
  uint64_t key_bytes_ = 0;    // of all names of edits
};

}  // namespace fire3dv::record
