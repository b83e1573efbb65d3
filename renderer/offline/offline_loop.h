// Draws moments of a recording one after the other, without a wait between them: the device always has the
// next frame, and finished images go to a sink, which encodes on threads of its own.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/camera_rig.h"
#include "renderer/app/live_scene.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/offline/frame_times.h"
#include "renderer/offline/recorded_show.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"
#include "renderer/state/animation.h"

namespace fire3dv::offline {

class OfflineLoop {
 public:
  // All is borrowed. animations: null where none play.
  struct Parts {
    gpu::Device& device;
    passes::SceneRenderer& renderer;
    state::PoseState& poses;
    RecordedShow& show;
    app::LiveScene& scene;
    std::optional<state::AnimationPlayer>* animations;
    app::CameraRig& camera;
    sinks::FrameSink& sink;
  };
  OfflineLoop(const Parts& parts, const FrameTimes& times);

  // The frames of the part that are not wanted are passed over. False: asked to stop before the last one.
  Result<bool> run(const Part& part, const std::function<bool(uint64_t frame)>& is_wanted,
                   const std::function<bool()>& should_stop);
  uint64_t images() const { return images_; }

 private:
  struct Tag {
    uint64_t frame;
    std::string camera;
    std::vector<state::FrameTag> shown;
  };
  void show(uint64_t frame);
  void draw(uint64_t frame);
  Result<void> deliver();

  Parts parts_;
  FrameTimes times_;
  gpu::FrameRing frames_;
  passes::ReadbackBelt<Tag> readback_;
  uint64_t images_ = 0;
};

}  // namespace fire3dv::offline
