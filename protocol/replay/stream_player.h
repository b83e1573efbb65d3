// One recorded stream onto one link. The link may be of another kind than the one that was recorded: frames
// are put together and cut again as it needs them.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/record/playback.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"

namespace fire3dv::replay {

struct PlayerCounts {
  uint64_t frames = 0;        // published
  uint64_t skipped = 0;       // stale, or built on one that is not in the recording
  uint64_t incomplete = 0;    // parts are missing
  uint64_t unkept_edits = 0;  // there are more than a link is given to keep
};

class StreamPlayer {
 public:
  // verbatim: the bytes as they were recorded. Otherwise publish times and the description's clock are those
  // of this machine now, as a renderer that compares them with its own clock needs them.
  StreamPlayer(std::unique_ptr<transport::PublisherLink> link, bool verbatim)
      : link_(std::move(link)), verbatim_(verbatim) {}

  // What follows is not continued from what was played: the first frame says so. new_epoch: sequences and
  // edits begin anew, as they must when the same frames come again.
  void jump(bool new_epoch);
  // What follows is published as of then, on this machine's monotonic clock; 0, the default: when it is
  // played.
  void publish_as_of(uint64_t monotonic_ns) { as_of_ns_ = monotonic_ns; }
  // Frames are put together and not published: send_gathered() publishes the newest whole one, alone. So that
  // what is shown at some moment need not be published from the frame on that it builds on.
  void gather() { gathering_ = true; }
  // False: there is no whole frame.
  bool send_gathered();
  bool has_gathered() const { return gathered_.has_value(); }
  // Something is described and has not ended.
  bool is_live() const { return epoch_ != 0 && !ended_; }
  // Of the newest frame that was published.
  std::optional<int64_t> sim_time_ns() const { return sim_time_ns_; }
  // An error is the link's.
  Result<void> play(const record::Played& played);
  // Says goodbye, unless the recording did.
  void end();
  // Takes what renderers say. Returns how many there are.
  uint32_t poll();
  std::string problem() const { return link_->problem(); }
  const PlayerCounts& counts() const { return counts_; }

 private:
  Result<void> play_description(const wire::StreamDescription& description,
                                std::span<const std::byte> message);
  Result<void> play_edit(const record::Played& played);
  void play_frame(const wire::PoseFrameView& frame, std::span<const std::byte> message);
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

  // What the link keeps for those who join later: it has no bound of its own.
  std::map<uint64_t, uint64_t> edit_bytes_of_key_;
  uint64_t edit_bytes_ = 0;

  uint64_t sequence_ = 0;  // that poses_ is of, or becomes
  uint32_t covered_ = 0;   // nodes of it that have come
  bool has_whole_ = false;
  std::vector<wire::Affine3x4> poses_;
  std::vector<wire::PoseFrameEncoder> encoders_;
  std::vector<wire::MessagePieces> parts_;
};

}  // namespace fire3dv::replay
