// CPU ray caster in double precision: the oracle for output planes (depth, instance, motion).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "renderer/passes/view/view.h"

namespace fire3dv::test {

// A triangle with counter-clockwise front-face winding.
struct Face {
  uint32_t instance;
  glm::dvec3 corner_world[3];
};

// Returns all triangles of the scene with its nodes at these world transforms.
std::vector<Face> faces_of(const scene::Scene& scene, const std::vector<glm::mat4>& world_from_node);

struct Hit {
  uint32_t instance = 0;  // 0: background
  size_t face = SIZE_MAX;
  double depth_m = 0;  // along the view axis
  glm::dvec3 point_world{0};
  glm::dvec3 normal_world{0};
};

// A camera by its intrinsics and pose. (0, 0) is the centre of the top left pixel.
struct Eye {
  passes::Intrinsics intrinsics;
  glm::dmat4 world_from_camera;

  Hit cast(const std::vector<Face>& faces, glm::dvec2 place_px) const;
  // Returns the hit only if it is certain: no other face lies within a hundredth of a pixel.
  std::optional<Hit> cast_surely(const std::vector<Face>& faces, glm::dvec2 place_px) const;
  // Intersects the ray with this face alone, without occlusion.
  std::optional<double> depth_of(const Face& face, glm::dvec2 place_px) const;
  glm::dvec2 project(const glm::dvec3& world) const;
  glm::dvec3 ray_world(glm::dvec2 place_px) const;  // its component along the view axis is 1
};

}  // namespace fire3dv::test
