#include "tools/lab/contact_sheet/asset_drawer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "renderer/camera/default_look.h"
#include "renderer/passes/resources/gpu_scene.h"

namespace fire3dv::contact_sheet {

AssetDrawer::AssetDrawer(gpu::Device& device, VkExtent2D extent, const settings::DrawSettings& settings)
    : frames_(device), renderer_(device, settings), readback_(device), settings_(settings), extent_(extent) {
  nothing_.materials.emplace_back();
  renderer_.set_scene(nothing_);
}

sinks::FrameImage AssetDrawer::draw(const scene::Scene& scene, const passes::View& view,
                                    std::optional<passes::Pick> pick) {
  renderer_.set_scene(scene);
  shown_ = &scene;
  const state::PoseState poses(scene);
  const Result<passes::PreparedFrame> prepared =
      renderer_.prepare({.extent = extent_, .inspection = {.pick = pick}});
  if (!prepared) throw std::runtime_error(prepared.error().message);
  gpu::Recorder& recorder = frames_.begin();
  renderer_.record(*prepared, recorder, frames_.staging(), poses, view);
  readback_.record(recorder, renderer_.image(), 0);
  const uint64_t done_at = frames_.submit();
  readback_.submitted(done_at);
  renderer_.submitted(done_at);
  sinks::FrameImage image;
  readback_.drain([&](int, VkExtent2D extent, std::span<const uint8_t> rgba8) {
    image.width = extent.width;
    image.height = extent.height;
    image.rgba8.assign(rgba8.begin(), rgba8.end());
  });
  return image;
}

sinks::FrameImage AssetDrawer::draw_framed(const scene::Scene& scene) {
  return draw(scene, framed_view(scene, aspect()));
}

sinks::FrameImage AssetDrawer::draw_by_default(const scene::Scene& scene) {
  settings::DrawSettings settings = settings_;
  (void)app::set_exposure(settings_.post, scene, settings);
  renderer_.apply(settings);
  const Result<app::CameraRig> rig = app::CameraRig::create(scene, app::camera_start({}, scene, "auto", {}));
  if (!rig) throw std::runtime_error(rig.error().message);
  return draw(scene, rig->view(state::PoseState(scene), aspect()));
}

sinks::FrameImage AssetDrawer::draw_nothing() {
  return draw_framed(nothing_);
}

DrawnCounts AssetDrawer::counts() const {
  DrawnCounts counts;
  for (const passes::Draw& draw : renderer_.gpu_scene().draw_list.draws) {
    const scene::Primitive& primitive = shown_->primitives[draw.primitive];
    switch (primitive.topology) {
      case scene::Topology::triangles:
        counts.triangles += primitive.index_count / 3;
        break;
      case scene::Topology::lines:
        counts.lines += primitive.index_count / 2;
        break;
      case scene::Topology::points:
        counts.points += primitive.index_count;
        break;
    }
  }
  return counts;
}

float AssetDrawer::aspect() const {
  const VkExtent2D extent = extent_;
  return static_cast<float>(extent.width) / static_cast<float>(extent.height);
}

passes::View framed_view(const scene::Scene& scene, float image_aspect) {
  scene::Camera camera;
  const glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max);
  const glm::vec3 half_extent = glm::max(0.5f * (scene.bounds_max - scene.bounds_min), glm::vec3(1e-4f));
  glm::mat4 pose = passes::look_at_pose(center + glm::vec3(0.6f, 0.45f, 1.0f), center);
  const glm::mat3 camera_from_world = glm::transpose(glm::mat3(pose));
  // Smallest distance at which all corners of the bounding box are visible, with a small margin.
  const float up = 0.94f * std::tan(camera.vertical_fov_rad / 2), right = up * image_aspect;
  float distance_m = 0;
  for (uint32_t i = 0; i < 8; ++i) {
    const glm::vec3 sides(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    const glm::vec3 corner = camera_from_world * (sides * half_extent);
    distance_m =
        std::max(distance_m, corner.z + std::max(std::abs(corner.x) / right, std::abs(corner.y) / up));
  }
  pose[3] = glm::vec4(center + distance_m * glm::vec3(pose[2]), 1);
  camera.near_m = 0.01f * std::clamp(distance_m, 1e-3f, 1.0f);
  return passes::make_view(camera, pose, image_aspect);
}

}  // namespace fire3dv::contact_sheet
