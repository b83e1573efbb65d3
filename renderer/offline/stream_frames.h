// One stream of a recording, put together as the renderer would: whole frames in order, from parts and
// partial frames, none before the edits that it belongs to.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "protocol/record/playback.h"
#include "protocol/wire/decode.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::offline {

class StreamFrames {
 public:
  StreamFrames();

  // What a message of the stream has brought. An edit may bring a frame too, which had waited for it.
  struct Taken {
    bool began = false, ended = false;
    bool edited = false;
    bool frame = false;  // header() and poses() are of a new one
    bool segment =
        false;  // with that frame simulated time begins anew: the first of a run, or time went back
  };
  Taken take(const record::Played& played);

  const wire::PoseFrameHeader& header() const { return frames_.streams()[*id_].header; }
  std::span<const wire::Affine3x4> poses() const { return frames_.streams()[*id_].poses; }
  uint64_t unusable() const { return unusable_; }  // messages that were passed over

 private:
  wire::Decoder decoder_;
  state::PoseState
      frames_;  // of a scene without nodes: only what it makes of a stream's messages counts here
  std::optional<state::StreamId> id_;
  uint64_t epoch_ = 0;
  std::optional<int64_t> sim_time_ns_;  // of the newest frame of this run
  uint64_t unusable_ = 0;
};

}  // namespace fire3dv::offline
