// Unique node names of an MJCF model, common to the scene converter and to publishers, so that every name
// binds.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

// Names as in the model, by index; unnamed objects have an empty one.
struct MjcfOwnNames {
  std::vector<std::string> bodies, cameras, lights, geoms, skins;
  std::vector<std::pair<std::string, size_t>> tendons;  // with their maximum number of points
};

// Bodies keep their names; other objects never take one of them.
struct MjcfNames {
  MjcfNames() = default;
  explicit MjcfNames(const MjcfOwnNames& own);
  explicit MjcfNames(const MjcfScene& scene);

  std::vector<std::string> bodies;  // "body_3" for an unnamed body
  std::string free_camera;          // initial view of MuJoCo's viewer
  std::string overview;             // camera that frames what is drawn, in models without a view of their own
  std::vector<std::string> cameras;
  std::vector<std::string> lights;
  // By tendon: straight segments of its path, "NAME#0", and balls at their ends, "NAME#end 0", for the
  // maximum number of points. Empty for tendons that are not drawn.
  std::vector<std::vector<std::string>> tendon_pieces, tendon_ends;
  std::vector<std::string> skins;
  std::vector<std::string>
      geoms;  // nodes exist for infinite planes, and with ReadOptions::geoms_apart for all
};

}  // namespace fire3dv::convert
