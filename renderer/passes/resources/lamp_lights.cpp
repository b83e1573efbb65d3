#include "renderer/passes/resources/lamp_lights.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include "shaders/shared/types.h"

namespace fire3dv::passes {

scene::Light lamp_light(const settings::LampSettings& lamps) {
  scene::Light light;
  light.type = scene::LightType::point;
  light.intensity = lamps.intensity_cd;
  light.spread = lamps.spread;
  return light;
}

glm::vec3 scope_center(const View& view, const scene::Scene& scene, const state::PoseState& poses) {
  constexpr float kMaxOffsetM = 0.02f;
  if (view.camera.empty()) return view.eye_world;
  const uint32_t node = poses.names().find(view.camera);
  if (node == scene::kNone || node >= scene.nodes.size()) return view.eye_world;
  const uint32_t parent = scene.nodes[node].parent;
  const glm::vec3 own(poses.world_from_node(node)[3]);
  glm::vec3 sum(0);
  uint32_t count = 0;
  for (uint32_t other = 0; parent != scene::kNone && other < scene.nodes.size(); ++other) {
    if (scene.nodes[other].parent != parent || scene.nodes[other].camera == scene::kNone) continue;
    sum += glm::vec3(poses.world_from_node(other)[3]) - own;
    ++count;
  }
  if (count > 1) return view.eye_world + sum / static_cast<float>(count);
  return glm::distance(own, view.eye_world) <= kMaxOffsetM ? own : view.eye_world;
}

namespace {

struct ImageAxes {
  glm::vec3 right_world, down_world;
};
ImageAxes image_axes(const View& view) {
  // Rays of orthographic views are parallel; rows of their projection have no perspective.
  const glm::mat4 rows = glm::transpose(view.clip_from_world);
  if (view.orthographic) return {glm::normalize(glm::vec3(rows[0])), glm::normalize(glm::vec3(rows[1]))};
  return {glm::normalize(view.world_from_ndc_x), glm::normalize(view.world_from_ndc_y)};
}

}  // namespace

void place_lamps(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                 const settings::LampSettings& lamps, std::span<const View> views,
                 std::span<const glm::vec3> centers) {
  if (scene.lamp_count == 0) return;
  std::vector<gpu_types::LightPose> poses;
  std::vector<VkBufferCopy> copies;
  const uint32_t first_lamp = scene.light_count - (scene.sun ? 1 : 0) - scene.lamp_count;
  const VkDeviceSize bytes = scene.lamp_count * sizeof(gpu_types::LightPose);
  for (size_t v = 0; v < views.size(); ++v) {
    const View& view = views[v];
    const ImageAxes axes = image_axes(view);
    copies.push_back({v * bytes,
                      scene.light_poses_offset() + view.world * scene.light_bytes +
                          first_lamp * sizeof(gpu_types::LightPose),
                      bytes});
    for (uint32_t lamp = 0; lamp < scene.lamp_count; ++lamp) {
      const float angle =
          2 * std::numbers::pi_v<float> * static_cast<float>(lamp) / static_cast<float>(scene.lamp_count);
      gpu_types::LightPose pose{};
      pose.color = glm::vec3(lamps.intensity_cd);
      pose.type = lamps.spread > 0 ? FIRE3DV_LIGHT_LAMP : FIRE3DV_LIGHT_POINT;
      pose.cone_scale = lamps.spread;
      pose.position_world =
          centers[v] +
          lamps.offset_mm / 1000 * (std::cos(angle) * axes.right_world - std::sin(angle) * axes.down_world);
      pose.light_direction_world = view.look_world;
      poses.push_back(pose);
    }
  }
  const gpu::StagingRing::Piece piece = staging.write(std::span<const gpu_types::LightPose>(poses));
  for (VkBufferCopy& copy : copies) copy.srcOffset += piece.offset;
  recorder.pass("lamps", {gpu::Use(scene.world_from_node, gpu::access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  vkCmdCopyBuffer(commands, piece.buffer, scene.world_from_node.get(),
                                  static_cast<uint32_t>(copies.size()), copies.data());
                });
}

}  // namespace fire3dv::passes
