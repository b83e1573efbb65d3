// Images for simulators that asked for them: what is due is drawn, and goes back over the link that it was
// asked over, with the frame that it shows.
#pragma once

#include <optional>
#include <vector>

#include "renderer/app/live_scene.h"
#include "renderer/app/stream_intake.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/passes/scene_renderer.h"

namespace fire3dv::app {

// What this renderer makes of what can be asked for.
state::ImageAbilities image_abilities();

class ImageService {
 public:
  // All is borrowed.
  ImageService(gpu::Device& device, passes::SceneRenderer& renderer, const state::PoseState& poses,
               StreamIntake& intake, const LiveScene& scene)
      : device_(device),
        renderer_(renderer),
        poses_(poses),
        intake_(intake),
        scene_(scene),
        readback_(device) {}

  // Draws what is due of what is shown now, each image in a submission of its own. Returns true when there
  // was any; the renderer then has the size of the last one.
  bool draw_due(gpu::FrameRing& frames);

  // Sends what is finished.
  void deliver();
  bool in_flight() const { return readback_.in_flight() != 0; }

 private:
  struct Tag {
    state::ImageBook::Asker asker = 0;
    wire::ImageFrame frame;
  };
  struct Camera {
    passes::Intrinsics intrinsics;
    glm::mat4 world_from_camera{1};
    float exposure = 0;
  };
  // Nothing: the asker was told why.
  std::optional<Camera> camera_of(const state::ImageBook::Due& due);
  void draw(gpu::FrameRing& frames, const state::ImageBook::Due& due, const Camera& camera);

  gpu::Device& device_;
  passes::SceneRenderer& renderer_;
  const state::PoseState& poses_;
  StreamIntake& intake_;
  const LiveScene& scene_;
  passes::ReadbackBelt<Tag> readback_;
};

}  // namespace fire3dv::app
