// Frame decoder of one recorded stream. It yields whole frames in order, assembled from parts and partial
// frames. As in a live renderer, a frame follows the scene edits that it depends on.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "protocol/record/playback.h"
#include "protocol/wire/decode.h"
#include "renderer/state/frame_receiver.h"

namespace fire3dv::offline {

class StreamFrames {
 public:
  // Effect of one message. An edit may release a frame that waited for it.
  struct Taken {
    bool began = false, ended = false;
    bool edited = false;
    bool frame = false;  // header() and poses() have a new frame
    // The frame begins a segment: it is the first of a run, or simulator time went back.
    bool segment = false;
  };
  Taken take(const record::Played& played);

  const wire::PoseFrameHeader& header() const { return receiver_->header; }
  std::span<const wire::Affine3x4> poses() const { return receiver_->poses; }
  uint64_t unusable() const { return unusable_; }  // skipped messages

 private:
  wire::Decoder decoder_;
  std::optional<state::FrameReceiver> receiver_;  // of the current run
  std::optional<int64_t> sim_time_ns_;  // of the newest frame of this run
  uint64_t unusable_ = 0;
};

}  // namespace fire3dv::offline
