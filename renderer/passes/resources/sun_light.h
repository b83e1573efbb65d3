// Lights that are drawn: those of the scene, of the lamps beside the lens, and of the environment's sun,
// which is the last one. Lamps and sun have no node.
#pragma once

#include <optional>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/scene/textures/environment_sun.h"

namespace fire3dv::passes {

// Lights beside those of the scene.
struct AddedLights {
  uint32_t lamps = 0;
  std::optional<scene::EnvironmentSun> sun;
};
inline AddedLights added_lights(const GpuScene& scene) {
  return {scene.lamp_count, scene.sun};
}

// Lights of the scene in node order, then the lamps and the sun, whose nodes are scene::kNone. edits: null
// where there are none.
std::vector<scene::PlacedLight> drawn_lights(const scene::Scene& scene, const scene::SceneEdits* edits,
                                             const AddedLights& added);

// Writes the pose of the sun for each world. Without a sun it records nothing.
void place_sun(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
               float environment_intensity, float rotation_rad);

}  // namespace fire3dv::passes
