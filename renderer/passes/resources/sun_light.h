// Light of the environment's sun: the last one of the lights that are drawn, after those of the scene. It has
// no node.
#pragma once

#include <optional>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/scene/textures/environment_sun.h"

namespace fire3dv::passes {

// Lights of the scene in node order, then the sun, whose node is scene::kNone. edits: null where there are
// none.
std::vector<scene::PlacedLight> drawn_lights(const scene::Scene& scene, const scene::SceneEdits* edits,
                                             const std::optional<scene::EnvironmentSun>& sun);

// Writes the pose of the sun for each world. Without a sun it records nothing.
void place_sun(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
               float environment_intensity, float rotation_rad);

}  // namespace fire3dv::passes
