// Triangles of a scene in world space, and their area.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// A sample of a primitive's triangles that suffices for means: every step-th one, some 4096 of many.
struct TriangleSample {
  uint32_t count, step;
  explicit TriangleSample(const Primitive& primitive)
      : count(primitive.topology == Topology::triangles ? primitive.index_count / 3 : 0),
        step(std::max(count / 4096, 1u)) {}
};

// Vertices of a triangle, undeformed.
std::array<glm::vec3, 3> triangle_corners(const Scene& scene, const Primitive& primitive, uint32_t triangle,
                                          const glm::mat4& world_from_node);

double area_of(const std::array<glm::vec3, 3>& triangle);

// Estimates in square metres, by samples of the triangles.
double surface_area(const Scene& scene, const Primitive& primitive, const glm::mat4& world_from_node);
double surface_area(const Scene& scene, const Node& node, const glm::mat4& world_from_node);

}  // namespace fire3dv::scene
