// Boxes around instances: in the image, from the pixels that show them, and in the world.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

// min inclusive, max exclusive. Rows of memory as BoxRecord2d of the wire.
struct Box2d {
  uint32_t instance = 0, semantic = 0;
  uint32_t min_x = 0, min_y = 0, max_x = 0, max_y = 0;
  uint32_t pixels = 0;  // that show it
};

// The cube from -0.5 to 0.5 in each axis, taken by this matrix, holds the node's mesh: in the node's own axes
// where it is rigid, in the world's where joints or morph targets move it.
struct Box3d {
  uint32_t instance = 0, semantic = 0;
  std::array<float, 12> world_from_box{};  // by rows
};

// Of every node that shows something, by rising instance, as it stands now.
std::vector<Box3d> boxes_of_instances(const scene::Scene& scene, const state::PoseState& poses);

// Of the instances that the image shows, by rising instance. instances: of each pixel, rows from the top.
std::vector<Box2d> boxes_in_image(std::span<const uint32_t> instances, uint32_t width,
                                  std::span<const Box3d> known);

// Those that the image shows.
std::vector<Box3d> seen_boxes(std::span<const Box3d> known, std::span<const Box2d> seen);

}  // namespace fire3dv::passes
