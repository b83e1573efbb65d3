// Screen-space bounds of forward-only draws (blended surfaces, lines, points).
#pragma once

#include "renderer/gpu/device/vk.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/view.h"

namespace fire3dv::passes {

// Empty where none is in view. The whole image for unknown bounds: deformed meshes, and boxes that cross the
// eye plane.
VkRect2D forward_bounds(const GpuScene& gpu_scene, const scene::Scene& scene, const state::PoseState& poses,
                        const View& view, VkExtent2D extent);

}  // namespace fire3dv::passes
