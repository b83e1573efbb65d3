#include "renderer/passes/resources/sun_light.h"

#include <cmath>
#include <cstdint>
#include <span>

#include "renderer/passes/resources/lamp_lights.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

std::vector<scene::PlacedLight> drawn_lights(const scene::Scene& scene, const scene::SceneEdits* edits,
                                             const AddedLights& added) {
  std::vector<scene::PlacedLight> lights = scene::lights_of(scene, edits);
  // place_lamps() writes intensity and direction.
  for (uint32_t lamp = 0; lamp < added.lamps; ++lamp) lights.push_back({lamp_light({}), scene::kNone});
  if (added.sun) lights.push_back({scene::light_of(*added.sun), scene::kNone});
  return lights;
}

void place_sun(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
               float environment_intensity, float rotation_rad) {
  if (!scene.sun) return;
  gpu_types::LightPose pose{};
  pose.color = environment_intensity * scene.sun->illuminance_lux;
  pose.type = FIRE3DV_LIGHT_DIRECTIONAL;
  pose.light_direction_world = -scene::world_direction(*scene.sun, rotation_rad);
  pose.angular_radius_rad = scene.sun->angular_radius_rad;
  pose.sine = std::sin(scene.sun->angular_radius_rad);
  const gpu::StagingRing::Piece piece = staging.write(std::span<const gpu_types::LightPose>(&pose, 1));
  std::vector<VkBufferCopy> copies;
  for (uint32_t world = 0; world < scene.world_count; ++world) {
    const VkDeviceSize of_world = scene.light_poses_offset() + world * scene.light_bytes;
    copies.push_back({piece.offset, of_world + (scene.light_count - 1) * sizeof(pose), sizeof(pose)});
  }
  recorder.pass("sun", {gpu::Use(scene.world_from_node, gpu::access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  vkCmdCopyBuffer(commands, piece.buffer, scene.world_from_node.get(),
                                  static_cast<uint32_t>(copies.size()), copies.data());
                });
}

}  // namespace fire3dv::passes
