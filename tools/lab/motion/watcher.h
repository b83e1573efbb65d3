// Listener that records arrival times of the reference motion's frames.
#pragma once

#include <cstdint>

#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"
#include "tools/lab/motion/score.h"

namespace fire3dv::motion {

class Watcher {
 public:
  // Allocates the whole recording immediately, so that later memory growth is not the recording's.
  explicit Watcher(size_t most_frames);

  // Processes pending messages and updates the stream's condition.
  void poll(transport::ListenerLink& link, int64_t now_ns);

  bool has_begun() const { return !recording_.empty(); }
  const Recording& recording() const { return recording_; }
  uint64_t frames_missing() const { return frames_missing_; }  // skipped sequences
  // Transitions to late and lost, and the current condition.
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
