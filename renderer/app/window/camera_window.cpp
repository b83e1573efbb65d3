#include "renderer/app/window/camera_window.h"

#include "renderer/app/screenshots/stale_overlay.h"
#include "renderer/app/window/viewer_control.h"

namespace fire3dv::app {

bool CameraWindow::steer(gui::Viewer& viewer, const state::PoseState& poses, float seconds) {
  const VkExtent2D extent = window_.framebuffer_extent();
  const CameraMoves moves = input_.take(window_.take_input(), {}, viewer);
  if (moves.click_px) clicked_px_ = moves.click_px;
  move_camera(camera_, moves, viewer, poses, {extent.width, extent.height}, seconds);
  return !std::exchange(viewer.commands.close, false) && !window_.should_close();
}

Result<void> CameraWindow::draw(passes::SceneRenderer& renderer, const state::PoseState& poses,
                                const gui::Viewer& viewer, uint64_t scene_number, StaleOverlay mark_held) {
  constexpr uint64_t kPatienceNs = 10'000'000;  // acquire timeout: a hidden window must not block the others
  if (!window_.acquire(kPatienceNs)) return {};
  const VkExtent2D extent = window_.framebuffer_extent();
  const Result<passes::PreparedFrame> prepared = renderer.prepare(
      {.extent = extent,
       .inspection = inspection_of(viewer, clicked_px_, {extent.width, extent.height}, scene_number)});
  if (!prepared) return prepared.error();
  gpu::Recorder& recorder = frames_.begin();
  const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
  renderer.record(*prepared, recorder, frames_.staging(), poses, camera_.view(poses, aspect));
  renderer.draw_stale_overlay(recorder, stale_condition(poses.streams(), mark_held));
  window_.record(recorder, renderer.image());
  renderer.submitted(frames_.submit(window_.waits(), window_.signals()));
  window_.present();
  return {};
}

}  // namespace fire3dv::app
