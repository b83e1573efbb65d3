// Nodes of an MJCF model: names, visibility and tendon geometry, common to the scene converter and to
// publishers of the compiled model, so that every name binds.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace fire3dv::convert {

// Bodies keep their names; other objects never take one of them.
struct MjcfNames {
  explicit MjcfNames(const mjModel& model);

  std::vector<std::string> bodies;   // nbody; "body_3" for an unnamed body
  std::string free_camera;           // initial view of MuJoCo's viewer
  std::vector<std::string> cameras;  // ncam
  std::vector<std::string> lights;   // nlight
  // By tendon: straight segments of its path, "NAME#0", and balls at their ends, "NAME#end 0", for the
  // maximum number of points. Empty for tendons that are not drawn.
  std::vector<std::vector<std::string>> tendon_pieces, tendon_ends;
  std::vector<std::string> geoms;  // ngeom; nodes exist only with ReadOptions::geoms_apart
};

// Groups 0 to 2, as in MuJoCo's viewer at start. By convention, collision geoms are in groups 3 and higher.
bool is_shown_group(int group);

// MuJoCo's precedence for geoms and tendons, in displayed (sRGB) colours: their own colour counts where it
// differs from the default.
std::array<float, 4> mjcf_color(const mjModel& model, int material, const float* own);

// Excludes lights that are off, black or without direction.
bool is_scene_light(const mjModel& model, int light);

// Geometry of spatial tendons as in MuJoCo's viewer: straight segments with balls at their ends. Points
// appear and disappear with the pose, but nodes cannot: the node count is the maximum, and unused nodes have
// scale 0. Metres.

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
