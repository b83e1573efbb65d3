// Shadow catcher of a view: a horizontal disc below the scene that shows shadows on the background.
#pragma once

#include <glm/glm.hpp>

namespace fire3dv::scene {

struct Ground {
  float height_m = 0;         // world y
  float radius_m = 0;         // shadows fade out towards it
  glm::vec2 center_world{0};  // x and z
};

}  // namespace fire3dv::scene
