// Geometry of spatial tendons as in MuJoCo's viewer: straight segments with balls at their ends. Points
// appear and disappear with the pose, but nodes cannot: the node count is the maximum, and unused nodes have
// scale 0. Metres.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

// Transform of a unit cylinder (radius 1, -1 to 1 along Z) or a unit ball.
struct TendonFrame {
  glm::dvec3 position{0};
  glm::dmat3 turn{1};
  glm::dvec3 scale{0};
};
TendonFrame piece_frame(const TendonPiece& piece);

// Computes the frames of all nodes of a tendon: max_points - 1 segments, then one end per point. Allocates
// nothing once `frames` has capacity.
void tendon_frames(const std::vector<TendonPiece>& pieces, size_t max_points,
                   std::vector<TendonFrame>& frames);

}  // namespace fire3dv::convert
