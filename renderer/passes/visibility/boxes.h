// Bounding boxes of instances: 2D boxes from the pixels that show them, and oriented 3D boxes in the world.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

// min inclusive, max exclusive. Same memory layout as BoxRecord2d of the wire.
struct Box2d {
  uint32_t instance = 0, semantic = 0;
  uint32_t min_x = 0, min_y = 0, max_x = 0, max_y = 0;
  uint32_t pixels = 0;  // visible pixels
};

// Oriented box: the matrix maps the cube from -0.5 to 0.5 to a box around the node's mesh. Its axes are the
// node's for rigid meshes and the world's for skinned or morphed ones.
struct Box3d {
  uint32_t instance = 0, semantic = 0;
  std::array<float, 12> world_from_box{};  // row-major
};

// Current boxes of all nodes with geometry, sorted by instance.
std::vector<Box3d> boxes_of_instances(const scene::Scene& scene, const state::PoseState& poses);

// Boxes of the visible instances, sorted by instance. instances: one per pixel, top-down rows.
std::vector<Box2d> boxes_in_image(std::span<const uint32_t> instances, uint32_t width,
                                  std::span<const Box3d> known);

// Filters the known boxes by visibility in the image.
std::vector<Box3d> seen_boxes(std::span<const Box3d> known, std::span<const Box2d> seen);

}  // namespace fire3dv::passes
