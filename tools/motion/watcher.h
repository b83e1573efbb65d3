// Stands where a renderer would and keeps when the frames of a known motion came.
#pragma once

#include <cstdint>

#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "renderer/scene/scene.h"
#include "renderer/state/pose_state.h"
#include "tools/motion/score.h"

namespace fire3dv::motion {

class Watcher {
 public:
  // Memory for so many frames is taken at once, so that what the process takes later is not the recording's.
  explicit Watcher(size_t most_frames);

  // Takes what has come, and looks how the stream stands.
  void poll(transport::ListenerLink& link, int64_t now_ns);

  bool has_begun() const { return !recording_.empty(); }
  const Recording& recording() const { return recording_; }
  uint64_t frames_missing() const { return frames_missing_; }  // sequences that were passed over
  // How often the stream became late and lost, and how it stands.
  uint64_t times_late() const { return times_late_; }
  uint64_t times_lost() const { return times_lost_; }
  state::Condition condition() const { return condition_; }

 private:
  void take(transport::PeerId peer, std::span<const std::byte> message, int64_t received_ns);
  void note_condition();

  size_t most_frames_;
  scene::Scene scene_;
  state::PoseState poses_{scene_};
  state::StreamId stream_ = state::kNone;
  transport::PeerId peer_ = 0;
  uint64_t epoch_ = 0;
  wire::Decoder decoder_;
  Recording recording_;
  uint64_t frames_missing_ = 0;
  state::Condition condition_ = state::Condition::live;
  uint64_t times_late_ = 0, times_lost_ = 0;
};

}  // namespace fire3dv::motion
