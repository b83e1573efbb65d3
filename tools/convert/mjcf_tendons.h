// Where spatial tendons run, as MuJoCo's viewer draws them: straight pieces from point to point, with balls
// at their ends. The points move, come and go with the pose; nodes cannot, so there are as many as are ever
// needed, and those that are not shrink to a point.
#pragma once

#include <mujoco/mujoco.h>

#include <glm/glm.hpp>
#include <vector>

namespace fire3dv::convert {

// Of a drawn tendon: no more points than these, one piece fewer. 0: a tendon of joints, in a group that is
// not shown, invisible or of no width.
int most_tendon_points(const mjModel& model, int tendon);

// In the frame of the world.
struct TendonPiece {
  glm::dvec3 from, to;
  double radius_m;
};

// Needs mj_tendon or more. Replaces what is in pieces; allocates nothing once it has room for
// most_tendon_points().
void tendon_pieces(const mjModel& model, const mjData& data, int tendon, std::vector<TendonPiece>& pieces);

// A cylinder's frame, of radius 1 from -1 to 1 along Z, and a ball's, of radius 1. Columns: x, y, z, place.
struct TendonFrame {
  glm::dvec3 place{0};
  glm::dmat3 turn{1};
  glm::dvec3 scale{0};
};
TendonFrame piece_frame(const TendonPiece& piece);

// The frames of all nodes of a tendon: most_tendon_points() - 1 pieces, then as many ends as there are
// points. frames must hold so many. pieces: scratch memory of the caller's.
void tendon_frames(const mjModel& model, const mjData& data, int tendon, std::vector<TendonPiece>& pieces,
                   std::vector<TendonFrame>& frames);

}  // namespace fire3dv::convert
