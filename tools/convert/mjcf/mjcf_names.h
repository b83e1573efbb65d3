// Node names and visibility of an MJCF model, common to the scene converter and to publishers of the compiled
// model, so that every name binds. Bodies keep their names; other objects never take one of them.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <string>
#include <vector>

namespace fire3dv::convert {

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

}  // namespace fire3dv::convert
