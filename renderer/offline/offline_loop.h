// Offline render loop: renders the frames of a recording at full speed. Frames in flight keep the device
// busy; the sink encodes finished images on its own threads.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "renderer/app/loading/live_scene.h"
#include "renderer/app/window/camera_rig.h"
#include "renderer/capture/capture_queue.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/offline/frame_times.h"
#include "renderer/offline/recorded_streams.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"
#include "renderer/state/animation.h"

namespace fire3dv::offline {

class OfflineLoop {
 public:
  // All members are borrowed. animations null: none play.
  struct Parts {
    gpu::Device& device;
    passes::SceneRenderer& renderer;
    state::PoseState& poses;
    RecordedStreams& streams;
    app::LiveScene& scene;
    std::optional<state::AnimationPlayer>* animations;
    app::CameraRig& camera;
    sinks::FrameSink& sink;
  };
  OfflineLoop(const Parts& parts, const FrameTimes& times);

  // Renders the frames of the part for which is_wanted is true. Returns false if should_stop ended it early.
  Result<bool> run(const Part& part, const std::function<bool(uint64_t frame)>& is_wanted,
                   const std::function<bool()>& should_stop);
  uint64_t images() const { return images_; }

 private:
  void advance(uint64_t frame);
  Result<void> draw(uint64_t frame);
  Result<void> deliver();

  Parts parts_;
  FrameTimes times_;
  gpu::FrameRing frames_;
  capture::CaptureQueue captures_;
  uint64_t images_ = 0;
};

}  // namespace fire3dv::offline
