// Guides of the window as markers: the ground grid with the world's axes, and the frusta of the scene's
// cameras.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "protocol/wire/marker.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::app {

// Side of a grid cell: 1, 2 or 5 times a power of ten, so that the grid is about as large as the scene.
float grid_cell_m(const scene::Scene& scene);
// The grid in the plane y = 0 of the world, ten cells to each side of the scene's centre, the axes at the
// origin, and the size of a cell as text. display_scale: factor on widths and texts.
std::vector<wire::Marker> ground_grid(const scene::Scene& scene, float display_scale);

// Pyramid, or box of an orthographic camera, in the camera's frame: the view up to depth_m, a mark above its
// upper edge, and the name. image_aspect: for cameras without an aspect ratio of their own.
std::vector<wire::Marker> camera_frustum(const scene::Camera& camera, const std::string& name, float depth_m,
                                         float image_aspect, bool is_selected, float display_scale);
// Depth at which the frusta of this scene end.
float frustum_depth_m(const scene::Scene& scene);

}  // namespace fire3dv::app
