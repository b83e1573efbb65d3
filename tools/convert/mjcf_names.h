// What the nodes of an MJCF model are called, and which of them are seen: in the scene that is made of it,
// and by whoever publishes poses of a compiled model. One text for both, so that every name binds. Bodies
// keep their own names; what is no body does not take one of theirs.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <string>
#include <vector>

namespace fire3dv::convert {

struct MjcfNames {
  explicit MjcfNames(const mjModel& model);

  std::vector<std::string> bodies;   // nbody; "body_3" where the model has none
  std::string free_camera;           // what MuJoCo's own viewer shows first
  std::vector<std::string> cameras;  // ncam
  std::vector<std::string> lights;   // nlight
  // Of each tendon: the straight pieces of its path, "NAME#0", and the balls at their ends, "NAME#end 0", as
  // many as there ever are. None for tendons that are not drawn.
  std::vector<std::vector<std::string>> tendon_pieces, tendon_ends;
  std::vector<std::string> geoms;  // ngeom; nodes of their own only where that was asked for
};

// MuJoCo's own viewer starts with the groups 0 to 2. Collision shapes are in 3 and higher, by custom.
bool is_shown_group(int group);

// MuJoCo's rule for geoms and tendons, of displayed colours: their own counts where it is not the default
// one.
std::array<float, 4> mjcf_color(const mjModel& model, int material, const float* own);

// Lights that are switched off, black or without direction are not in the scene.
bool is_scene_light(const mjModel& model, int light);

}  // namespace fire3dv::convert
