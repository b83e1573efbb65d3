// A window beside the first: one more camera of the scene that is shown.
#pragma once

#include "renderer/app/camera_rig.h"
#include "renderer/app/play_options.h"
#include "renderer/app/viewer_input.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/window.h"

namespace fire3dv::app {

class CameraWindow {
 public:
  // Borrows both. The window is attached to the device.
  CameraWindow(gpu::Device& device, sinks::Window& window, CameraRig camera)
      : window_(window), camera_(std::move(camera)), frames_(device) {}

  // What the user does here, with wishes that hold everywhere. False: it is to be closed.
  bool steer(gui::Viewer& viewer, const state::PoseState& poses, float seconds);
  // Where it can be shown now.
  void draw(passes::SceneRenderer& renderer, const state::PoseState& poses, const gui::Viewer& viewer,
            uint64_t scene_number, MarkHeld mark_held);

  const sinks::Window& window() const { return window_; }
  CameraRig& camera() { return camera_; }

 private:
  sinks::Window& window_;
  CameraRig camera_;
  ViewerInput input_;
  gpu::FrameRing frames_;
  std::optional<glm::vec2> clicked_px_;
};

}  // namespace fire3dv::app
