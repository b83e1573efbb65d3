// Publisher of one recorded stream on one link, which may be of another kind than the recorded one. Assembles
// frames from their parts and splits them again for the link. Publishes a frame completely or not at all.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/record/playback.h"
#include "protocol/stream/frame_assembler.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"

namespace fire3dv::replay {

struct PlayerCounts {
  uint64_t frames = 0;         // published
  uint64_t skipped = 0;        // stale, duplicated, contradictory, or partial messages without a base frame
  uint64_t incomplete = 0;     // frames with missing parts
  uint64_t dropped_edits = 0;  // edits beyond the memory limit of the link
};

class StreamPlayer {
 public:
  // verbatim: publishes the recorded bytes. Otherwise replaces publish times and the description's clock by
  // those of this machine, which renderers compare with their own clock.
  StreamPlayer(std::unique_ptr<transport::PublisherLink> link, bool verbatim)
      : link_(std::move(link)), verbatim_(verbatim) {}

  // Starts a discontinuity: the first frame after it carries the flag. new_epoch: restarts sequence numbers
  // and edits, required when frames are repeated.
  void jump(bool new_epoch);
  // Sets the publish time of the following messages on this machine's monotonic clock. 0 (default): the time
  // of playing.
  void set_publish_time(uint64_t monotonic_ns) { as_of_ns_ = monotonic_ns; }
  // Assembles frames without publishing them until publish_assembled() publishes the newest whole one. A seek
  // thereby skips the frames that the target frame builds on.
  void begin_assembly() { gathering_ = true; }
  // Returns false if no whole frame is available.
  bool publish_assembled();
  bool has_assembled() const { return gathered_.has_value(); }
  std::optional<uint64_t> assembled_sequence() const {
    return gathered_ ? std::optional(gathered_->sequence) : std::nullopt;
  }
  // True between the description and the end of the stream.
  bool is_live() const { return epoch_ != 0 && !ended_; }
  // Simulated time of the newest published frame.
  std::optional<int64_t> sim_time_ns() const { return sim_time_ns_; }
  // Errors come from the link only.
  Result<void> play(const record::Played& played);
  // Sends Goodbye unless the recording did.
  void end();
  // Discards the renderers' replies. Returns their number.
  uint32_t poll();
  std::string problem() const { return link_->problem(); }
  const PlayerCounts& counts() const { return counts_; }

 private:
  Result<void> play_description(const wire::StreamDescription& description,
                                std::span<const std::byte> message);
  Result<void> play_edit(const record::Played& played);
  void play_frame(const wire::PoseFrameView& frame, std::span<const std::byte> message);
  void play_part(const wire::PoseFrameView& part);
  void play_partial(const wire::PoseFrameView& frame, std::span<const std::byte> message);
  void set_newest(uint64_t sequence);
  void reset_frames();
  void send_whole(wire::PoseFrameView frame);
  void send_partial(wire::PoseFrameView frame, std::span<const std::byte> message);
  void cut(wire::PoseFrameView whole);
  uint64_t publish_time_ns() const;

  std::unique_ptr<transport::PublisherLink> link_;
  bool verbatim_;
  wire::Decoder decoder_, reply_decoder_;
  std::vector<std::byte> reply_;
  PlayerCounts counts_;

  uint64_t recorded_epoch_ = 0, epoch_ = 0;
  bool fresh_epoch_ = false, jumped_ = false, ended_ = false;
  bool gathering_ = false;
  uint32_t node_count_ = 0;
  uint64_t as_of_ns_ = 0;
  std::optional<wire::PoseFrameHeader> gathered_;
  std::optional<int64_t> sim_time_ns_;

  // Bytes of edits that the link stores for late joiners; the link itself has no limit.
  std::map<uint64_t, uint64_t> edit_bytes_of_key_;
  uint64_t edit_bytes_ = 0;

  stream::FrameAssembler assembler_;
  uint64_t begun_sequence_ = 0;         // newest frame with any played message
  uint64_t sequence_ = 0;               // sequence of poses_; 0: none
  std::vector<wire::Affine3x4> poses_;  // newest whole frame, updated by later partial frames
  std::vector<wire::PoseFrameEncoder> encoders_;
  std::vector<wire::MessagePieces> parts_;
};

}  // namespace fire3dv::replay
