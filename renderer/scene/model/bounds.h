// Axis-aligned bounding boxes of primitives, nodes and the scene, including deformation. They are
// conservative: no rendered point lies outside, rounding included.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>

#include "renderer/scene/model/scene.h"

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

// Computes bounds and joint bounds of all primitives with morph targets or influences. Requires nodes, skins
// and animations.
void bound_deformed_primitives(Scene& scene);

// World-space bounding box of a node's mesh at the given node transforms; empty without a mesh.
Box bounds_in_world(const Scene& scene, uint32_t node, std::span<const glm::mat4> world_from_node);

// True for nodes whose mesh stands for an infinite surface.
inline bool is_unbounded(const Scene& scene, uint32_t node) {
  return scene.nodes[node].mesh != kNone && scene.meshes[scene.nodes[node].mesh].unbounded;
}

// Computes Scene::bounds_min and bounds_max. Unbounded meshes do not count beside others.
void find_world_bounds(Scene& scene);

}  // namespace fire3dv::scene
