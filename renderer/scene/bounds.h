// Boxes around what is drawn, with everything that may deform it. They are conservative: rounding included,
// nothing that is shown lies outside.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>

#include "renderer/scene/scene.h"

namespace fire3dv::scene {

struct Box {
  glm::vec3 low{std::numeric_limits<float>::max()};
  glm::vec3 high{std::numeric_limits<float>::lowest()};

  bool empty() const { return low.x > high.x; }
  void add(const glm::vec3& point) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  void add(const Box& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
};

// Bounds and joint bounds of all primitives with morph targets or influences; after nodes, skins and
// animations.
void bound_deformed_primitives(Scene& scene);

// The box of a node's mesh in the world, for transforms of all nodes; empty without a mesh.
Box bounds_in_world(const Scene& scene, uint32_t node, std::span<const glm::mat4> world_from_node);

// Scene::bounds_min and bounds_max.
void find_world_bounds(Scene& scene);

}  // namespace fire3dv::scene
