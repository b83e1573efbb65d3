// Streams as they come, into recordings: sorts their messages into channels, repeats what a stream's state is
// where players may begin, counts what is missing, and begins a new file when one is long enough.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/error.h"
#include "protocol/record/foxglove.h"
#include "protocol/record/frame_tally.h"
#include "protocol/record/stream_names.h"
#include "protocol/record/writer.h"
#include "protocol/wire/decode.h"

namespace fire3dv::record {

struct LogOptions {
  WriterOptions writer;
  uint64_t chunk_ns =
      1'000'000'000;  // a chunk ends when it is so old: what is lost when everything ends at once
  // What was received until now is flushed to the disk when the last flush is so old. 0: each file when it is
  // finished.
  uint64_t flush_ns = 1'000'000'000;
  // What is kept for snapshots: so much of descriptions, and as much of edits. Streams that ended give way,
  // the oldest first.
  uint64_t most_kept_bytes = uint64_t{256} << 20;
  // 0: one file. Bytes of messages: not what each file begins with, which may be longer than that.
  uint64_t split_bytes = 0, split_ns = 0;
  // Beside our messages Foxglove's: where each node is, and these models.
  bool foxglove = false;
  std::vector<FoxgloveModel> models;
};

// Counts of one stream: of all that was received; after finish(), of what is in the files.
struct StreamSeen {
  std::string name;  // the adapter's, and a number where two have the same
  uint32_t nodes = 0;
  bool live = false;
  uint64_t epoch = 0, sequence = 0;
  uint64_t frames = 0, messages = 0, bytes = 0, edits = 0;
  uint64_t parts = 0;       // messages that were a part of a frame, as datagrams are
  uint64_t missing = 0;     // sequences that never came, or that the disk did not take
  uint64_t incomplete = 0;  // frames of which parts are missing
  uint64_t late = 0;        // messages that came after a newer frame
};

struct MessageCounts {
  uint64_t frames = 0, messages = 0, bytes = 0, edits = 0, parts = 0;
  MessageCounts& operator+=(const MessageCounts& other);
};

class StreamLog {
 public:
  // Called for each file, from 0. The writer is new; on_file may attach things to it.
  using MakeSink = std::function<Result<std::unique_ptr<Sink>>(uint32_t file)>;
  using OnFile = std::function<Result<void>(Writer& writer, uint64_t log_time_ns)>;

  StreamLog(MakeSink make_sink, OnFile on_file, const LogOptions& options);

  // One message that peer sent. Messages that are not sound are counted and left out; an error is the disk's.
  Result<void> take(uint64_t peer, std::span<const std::byte> message, uint64_t log_time_ns);
  // The peer is gone. One of the same name that comes later goes on with its stream.
  void end_peer(uint64_t peer);
  // To be called from time to time, whether something comes or not.
  Result<void> tick(uint64_t now_ns);
  // The file is whole afterwards. After an error, too, if there is room.
  Result<void> finish();

  std::vector<StreamSeen> streams() const;
  uint64_t refused() const { return refused_; }            // not sound, or of nobody who described himself
  uint64_t unkept_edits() const { return unkept_edits_; }  // not in snapshots, since these would be too long
  uint64_t file_bytes() const { return closed_bytes_ + (writer_ ? writer_->file_bytes() : 0); }
  uint32_t files() const { return files_; }
  uint64_t lost_messages() const { return lost_messages_; }  // in chunks that the disk did not take
  // Streams that are not recorded: as many are live as can be recorded, or their descriptions take too much
  // memory, or the file has as many channels as readers take. Counted once for each connection.
  uint64_t unrecorded_streams() const { return unrecorded_streams_; }
  // Ended streams whose slots were given to newer streams. They are in the files, but not in streams().
  uint64_t reclaimed_streams() const { return reclaimed_streams_; }
  uint64_t reclaimed_frames() const { return reclaimed_.frames; }

 private:
  struct Stream {
    StreamSeen seen;
    MessageCounts next, in_chunk, lost;  // message being taken; open chunk; chunks that the disk did not take
    wire::ClockInfo clock;
    FrameTally tally;
    Bytes description;
    std::map<std::pair<std::string, wire::Property>, std::pair<uint64_t, Bytes>> edits;  // version, message
    std::map<uint64_t, Bytes> unknown_edits;  // by version: nobody here knows which of them replaces which
    uint64_t version = 0;                     // of the newest edit
    uint64_t ended_as = 0;                    // which ending of all streams' this was
    uint64_t snapshot_bytes = 0;              // of description and edits together
    // Of the file that is being written.
    std::array<uint16_t, kRoles.size()> channels{};
    bool described_here = false;
    uint64_t described_at_bytes = 0;  // of news_bytes_
    FoxgloveTransforms transforms;
    uint16_t transforms_channel = 0;
  };

  Stream* stream_of(uint64_t peer);
  void end(Stream& stream);
  void forget(Stream& stream);
  Stream* take_over(uint64_t peer, uint64_t epoch);
  void leave(uint64_t peer, size_t stream);
  bool make_room_for_edit(uint64_t bytes);
  bool forget_oldest_ended();  // false: none is left
  std::optional<size_t> free_slot();  // that of the stream which ended first, where none is unused
  std::optional<size_t> new_stream(const std::string& name);
  bool has_room_for_channels(const std::string& name);
  void refuse_stream(uint64_t peer);
  void settle_chunk();
  Result<void> prepare_write(Stream& stream, bool describes);
  Result<uint16_t> channel_of(const std::string& stream, size_t which, uint16_t schema,
                              std::string_view role);
  Result<void> take_description(uint64_t peer, const wire::StreamDescription& description,
                                std::span<const std::byte> message);
  Result<void> take_frame(Stream& stream, const wire::PoseFrameView& frame,
                          std::span<const std::byte> message);
  Result<void> take_edit(Stream& stream, const wire::SceneEdit* edit, uint64_t version,
                         std::span<const std::byte> message);
  Result<void> write(Stream& stream, Role role, uint64_t publish_time_ns, uint32_t sequence,
                     std::span<const std::byte> message, bool describes = false);
  Result<void> write_plain(Stream& stream, Role role, uint64_t publish_time_ns, uint32_t sequence,
                           std::span<const std::byte> message);
  Result<void> write_transforms(Stream& stream, const wire::PoseFrameView& frame, uint64_t publish_time_ns);
  Result<void> write_models();
  Result<void> open_file();
  Result<void> close_file();
  Result<void> write_snapshots(const Stream* described);  // all but this one's
  Result<void> write_snapshot(Stream& stream);

  MakeSink make_sink_;
  OnFile on_file_;
  LogOptions options_;
  wire::Decoder decoder_;
  std::optional<Writer> writer_;
  uint32_t files_ = 0;
  std::optional<Error> open_failure_;  // no sink is asked for again: the first one may be used up
  uint64_t closed_bytes_ = 0;
  uint64_t own_beginning_bytes_ = 0;  // of the file: schema, attachments, first snapshots
  bool chunk_has_snapshots_ = false;  // that were due: a chunk that Foxglove's begin has them behind
  uint64_t file_begun_ns_ = 0, chunk_begun_ns_ = 0, now_ns_ = 0;
  uint16_t schema_ = 0, transforms_schema_ = 0;  // of the file that is being written
  std::vector<std::unique_ptr<Stream>> streams_;
  std::map<uint64_t, size_t> stream_of_peer_;
  uint64_t news_bytes_ = 0;                          // of all that was written and is no snapshot
  uint64_t edit_bytes_ = 0, description_bytes_ = 0;  // that are kept for snapshots
  uint64_t endings_ = 0;
  // Of the file that is being written: channel ids by stream and role, the last one of transforms; and the
  // memory that a reader needs for them.
  std::map<std::string, std::array<uint16_t, kRoles.size() + 1>> file_channels_;
  uint64_t channel_bytes_ = 0;
  bool file_is_full_ = false;  // of channels: a series goes on in a new file
  std::set<uint64_t> unrecorded_peers_;
  uint64_t unrecorded_streams_ = 0;
  uint64_t reclaimed_streams_ = 0;
  MessageCounts reclaimed_, reclaimed_in_chunk_;
  uint64_t flushed_ns_ = 0;
  uint64_t flushed_bytes_ = 0;  // of the file that is being written
  uint64_t refused_ = 0, unkept_edits_ = 0, lost_messages_ = 0;
  uint64_t file_messages_ = 0, file_lost_messages_ = 0;  // of the file that is being written
};

}  // namespace fire3dv::record
