// Geometry of spatial tendons as in MuJoCo's viewer: straight segments with balls at their ends. Points
// appear and disappear with the pose, but nodes cannot: the node count is the maximum, and unused nodes have
// scale 0. Metres.
#pragma once

#include <mujoco/mujoco.h>

#include <glm/glm.hpp>
#include <vector>

namespace fire3dv::convert {

// Returns the maximum number of points of a drawn tendon; segments are one fewer. 0: not drawn (joint tendon,
// hidden group, transparent or without width).
int most_tendon_points(const mjModel& model, int tendon);

// In the world frame.
struct TendonPiece {
  glm::dvec3 from, to;
  double radius_m;
};

// Requires mj_tendon or more. Overwrites pieces; allocates nothing once it has capacity for
// most_tendon_points().
void tendon_pieces(const mjModel& model, const mjData& data, int tendon, std::vector<TendonPiece>& pieces);

// Transform of a unit cylinder (radius 1, -1 to 1 along Z) or a unit ball.
struct TendonFrame {
  glm::dvec3 place{0};
  glm::dmat3 turn{1};
  glm::dvec3 scale{0};
};
TendonFrame piece_frame(const TendonPiece& piece);

// Computes the frames of all nodes of a tendon: most_tendon_points() - 1 segments, then one end per point.
// frames: sized by the caller. pieces: scratch memory.
void tendon_frames(const mjModel& model, const mjData& data, int tendon, std::vector<TendonPiece>& pieces,
                   std::vector<TendonFrame>& frames);

}  // namespace fire3dv::convert
