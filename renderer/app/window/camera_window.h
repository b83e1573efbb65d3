// Secondary window: another camera view of the displayed scene.
#pragma once

#include "renderer/app/options/play_options.h"
#include "renderer/app/window/camera_rig.h"
#include "renderer/app/window/viewer_input.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/window.h"

namespace fire3dv::app {

class CameraWindow {
 public:
  // Borrows device and window. The window is attached to the device.
  CameraWindow(gpu::Device& device, sinks::Window& window, CameraRig camera)
      : window_(window), camera_(std::move(camera)), frames_(device) {}

  // Handles the window's input, including global commands. Returns false if the window is to be closed.
  bool steer(gui::Viewer& viewer, const state::PoseState& poses, float seconds);
  // Renders and presents; skips the frame if the window cannot be shown.
  Result<void> draw(passes::SceneRenderer& renderer, const state::PoseState& poses, const gui::Viewer& viewer,
                    uint64_t scene_number, StaleOverlay mark_held);

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
