// Alias table over an environment image, for sampling directions by radiance. No Vulkan.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/textures/environment.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct EnvironmentCells {
  glm::uvec2 size{0};                             // cells along u and v
  std::vector<gpu_types::EnvironmentCell> cells;  // top row first; empty for a black image
};

// Densities follow luminance times solid angle, averaged over a cell and its neighbours, since bilinear
// filtering spreads a texel's light. Images wider than 1024 texels have cells of several texels.
EnvironmentCells make_environment_cells(const scene::EnvironmentImage& image);

}  // namespace fire3dv::passes
