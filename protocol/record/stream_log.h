// Recorder of live streams: sorts messages into channels, writes snapshots, counts losses, splits files.
// More than 60 members: a lost chunk must correct the counts of all streams, channels and snapshots in it.
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

#include "base/error.h"
#include "protocol/record/channels.h"
#include "protocol/record/file_channels.h"
#include "protocol/record/foxglove.h"
#include "protocol/record/foxglove_log.h"
#include "protocol/record/frame_counter.h"
#include "protocol/record/mcap/writer.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/limits.h"

namespace fire3dv::record {

struct LogOptions {
  WriterOptions writer;
  uint64_t chunk_ns = 1'000'000'000;  // maximum age of a chunk: bounds the loss if the process dies
  // Maximum age of the last flush to the disk. 0: each file is flushed only when it is finished.
  uint64_t flush_ns = 1'000'000'000;
  // Memory limit for snapshots: once for descriptions and once for edits. Ended streams are dropped first,
  // the oldest before all.
  uint64_t max_snapshot_bytes = wire::kMaxSceneEditBytes;
  // 0: one file. Counts message bytes after the file's initial schema, attachments and snapshots, which may
  // be longer.
  uint64_t split_bytes = 0, split_ns = 0;
  // Also records Foxglove messages: the transforms of all nodes, markers, and these models.
  bool foxglove = false;
  std::vector<FoxgloveModel> models;
};

// Counts of one stream: of all received messages; after finish(), of the messages in the files.
struct StreamSeen {
  std::string name;  // the adapter's name, with a number if it is not unique
  uint32_t nodes = 0;
  bool live = false;
  uint64_t epoch = 0, sequence = 0;
  uint64_t frames = 0, messages = 0, bytes = 0, edits = 0;
  uint64_t parts = 0;       // messages that carry a part of a frame, such as datagrams
  uint64_t missing = 0;     // sequence numbers that never arrived or were lost by the disk
  uint64_t incomplete = 0;  // frames with missing parts
  uint64_t late = 0;        // messages that arrived after a newer frame
};

struct MessageCounts {
  uint64_t frames = 0, messages = 0, bytes = 0, edits = 0, parts = 0;
  MessageCounts& operator+=(const MessageCounts& other);
};

class StreamLog {
 public:
  // Called for each file, from 0, with a new writer. on_file may add attachments.
  using MakeSink = std::function<Result<std::unique_ptr<Sink>>(uint32_t file)>;
  using OnFile = std::function<Result<void>(Writer& writer, uint64_t log_time_ns)>;

  StreamLog(MakeSink make_sink, OnFile on_file, const LogOptions& options);

  // Records one message of a peer. Invalid messages are counted and dropped; errors come only from the disk.
  Result<void> take(uint64_t peer, std::span<const std::byte> message, uint64_t log_time_ns);
  // Marks the peer's stream as ended. A later peer with the same name continues it.
  void end_peer(uint64_t peer);
  // Must be called regularly, also without messages.
  Result<void> tick(uint64_t now_ns);
  // Completes the file; also worth a call after an error, if there is space.
  Result<void> finish();

  std::vector<StreamSeen> streams() const;
  uint64_t refused() const { return refused_; }              // invalid, or from a peer without a description
  uint64_t dropped_edits() const { return dropped_edits_; }  // missing from snapshots for lack of memory
  uint64_t file_bytes() const { return closed_bytes_ + (writer_ ? writer_->file_bytes() : 0); }
  uint32_t files() const { return files_; }
  uint64_t lost_messages() const { return lost_messages_; }  // in chunks that the disk did not take
  // Streams that are not recorded, because of the limit on live streams, on description memory or on channels
  // of a file. Counted once per connection.
  uint64_t unrecorded_streams() const { return unrecorded_streams_; }
  // Ended streams whose slots newer streams reuse. They are in the files, but not in streams().
  uint64_t reclaimed_streams() const { return reclaimed_streams_; }
  uint64_t reclaimed_frames() const { return reclaimed_.frames; }
  uint64_t reclaimed_missing() const { return reclaimed_missing_; }  // missing or incomplete frames of them
  // First file that was removed, moved or replaced while it was written, in one sentence. Checked every
  // second; finish() fails for it, too.
  const std::optional<std::string>& name_fault() const { return name_fault_; }
  // Values of markers that are missing in Foxglove's channels: images, too long, or too many.
  uint64_t unconverted_markers() const;

 private:
  struct Stream {
    StreamSeen seen;
    MessageCounts next, in_chunk, lost;  // current message; open chunk; chunks that the disk did not take
    wire::ClockInfo clock;
    FrameCounter tally;
    Bytes description;
    std::map<std::pair<std::string, wire::Property>, std::pair<uint64_t, Bytes>> edits;  // version, message
    std::map<uint64_t, Bytes> unknown_edits;  // by version: edits of later minor versions
    uint64_t version = 0;                     // of the newest edit
    uint64_t ended_as = 0;                    // ordinal of this ending among all streams' endings
    uint64_t snapshot_bytes = 0;              // description and edits
    // State in the current file.
    std::array<uint16_t, kRoles.size()> channels{};
    bool in_current_file = false;
    uint64_t described_at_bytes = 0;  // value of message_bytes_ at the last snapshot
    FoxgloveLog::Stream foxglove;
  };

  Stream* stream_of(uint64_t peer);
  void end(Stream& stream);
  void drop_state(Stream& stream);
  Stream* take_over(uint64_t peer, uint64_t epoch);
  void leave(uint64_t peer, size_t stream);
  bool reserve_edit_memory(uint64_t bytes);
  bool evict_oldest_ended();          // false: none left
  std::optional<size_t> free_slot();  // reuses the slot of the stream that ended first if none is free
  std::optional<size_t> new_stream(const std::string& name);
  bool can_add_channels(const std::string& name);
  void refuse_stream(uint64_t peer);
  void account_closed_chunk();
  void check_name(uint64_t now_ns);
  Result<void> prepare_write(Stream& stream, bool describes);
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
  Result<void> write_models();
  FoxgloveLog::Output foxglove_output();
  Result<void> write_all_markers(Stream& stream);
  Result<void> open_file();
  Result<void> close_file();
  Result<void> write_snapshots(const Stream* described);  // except the stream `described`
  Result<void> write_snapshot(Stream& stream);

  MakeSink make_sink_;
  OnFile on_file_;
  LogOptions options_;
  wire::Decoder decoder_;
  wire::Decoder snapshot_decoder_;  // while values of decoder_ are in use
  std::optional<Writer> writer_;
  uint32_t files_ = 0;
  std::optional<Error> open_failure_;  // the sink is not requested again: the first one may be used up
  uint64_t closed_bytes_ = 0;
  uint64_t initial_bytes_ = 0;        // initial bytes of the file: schema, attachments, first snapshots
  bool chunk_has_snapshots_ = false;  // due snapshots of this chunk are written; a chunk may begin with
                                      // Foxglove messages, which they follow
  uint64_t file_begun_ns_ = 0, chunk_begun_ns_ = 0, now_ns_ = 0;
  // In the current file.
  uint16_t schema_ = 0;
  FileChannels channels_;
  FoxgloveLog foxglove_;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::map<uint64_t, size_t> stream_of_peer_;
  uint64_t message_bytes_ = 0;                       // bytes of all messages that are not snapshots
  uint64_t edit_bytes_ = 0, description_bytes_ = 0;  // retained for snapshots
  uint64_t endings_ = 0;
  bool file_is_full_ = false;  // no more channels: a split recording continues in a new file
  std::set<uint64_t> unrecorded_peers_;
  uint64_t unrecorded_streams_ = 0;
  uint64_t reclaimed_streams_ = 0;
  MessageCounts reclaimed_, reclaimed_in_chunk_;
  uint64_t reclaimed_unconverted_ = 0, reclaimed_missing_ = 0;
  std::optional<std::string> name_fault_;
  uint64_t name_checked_ns_ = 0;
  uint64_t flushed_ns_ = 0;
  uint64_t flushed_bytes_ = 0;  // in the current file
  uint64_t refused_ = 0, dropped_edits_ = 0, lost_messages_ = 0;
  uint64_t file_messages_ = 0, file_lost_messages_ = 0;  // in the current file
};

}  // namespace fire3dv::record
