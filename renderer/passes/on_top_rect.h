// Where in the image that can be which the forward pass draws on top: blended surfaces, lines and points.
#pragma once

#include "renderer/gpu/vk.h"
#include "renderer/passes/gpu_scene.h"
#include "renderer/passes/view.h"

namespace fire3dv::passes {

// Of no size where nothing of it is in view. The whole image where it cannot be told: what is deformed, and
// what reaches the plane of the eye.
VkRect2D on_top_rect(const GpuScene& gpu_scene, const scene::Scene& scene, const state::PoseState& poses,
                     const View& view, VkExtent2D extent);

}  // namespace fire3dv::passes
