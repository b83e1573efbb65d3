// Lights of the lamps beside a camera's lens: after those of the scene, before the environment's sun. They
// have no node; each image places them.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/settings/optics_settings.h"

namespace fire3dv::passes {

scene::Light lamp_light(const settings::LampSettings& lamps);

// Center of the lamps of a camera. Cameras of one parent node are those of one scope: the middle of their
// lenses. Else the camera's node, if the lens is within 2 cm of it: images of one node with different offsets
// share it, too. Else the lens.
glm::vec3 scope_center(const View& view, const scene::Scene& scene, const state::PoseState& poses);

// Writes the poses of the lamps for each view's world: around the center, in the plane of the lens, at even
// angles from the right. Without lamps it records nothing. centers: one per view.
void place_lamps(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                 const settings::LampSettings& lamps, std::span<const View> views,
                 std::span<const glm::vec3> centers);

}  // namespace fire3dv::passes
