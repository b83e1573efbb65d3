// Physics of settled poses: drops rigid bodies onto fixed triangles until they rest. A function of its input
// alone: no state is left from one call to the next. By Bullet, which a build may lack.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <span>
#include <vector>

#include "base/error.h"

namespace fire3dv::dataset {

// Bodies have the convex hulls of their meshes.
using Hull = std::vector<glm::vec3>;  // points in the body's axes, metres

struct FallingBody {
  std::vector<Hull> hulls;
  glm::dquat rotation{1, 0, 0, 0};  // world from body
  glm::dvec3 position_m{0};         // in the world, Y up
};

struct FixedTriangles {
  std::vector<glm::vec3> positions_m;  // in the world
  std::vector<uint32_t> indices;
};

struct RestingBody {
  glm::dquat rotation{1, 0, 0, 0};
  glm::dvec3 position_m{0};
  bool is_at_rest = false;  // false: it still moves after the last step
  bool has_fallen = false;  // below all fixed triangles: the pose is the one that it began with
};

constexpr uint32_t kMaxSettleSteps = 2400;
constexpr size_t kMaxHullPoints = 512;
constexpr size_t kMaxFixedTriangles = 4'000'000;

// Points of the convex hull: all corners of simple bodies, of others the extreme ones along so many
// directions that the hull is smaller by less than 1 % of the body's size.
Hull hull_of(std::span<const glm::vec3> points);

// Error if the build has no Bullet, for more than kMaxFixedTriangles, and for bodies without volume.
Result<std::vector<RestingBody>> settle(const FixedTriangles& fixed, std::span<const FallingBody> bodies);

}  // namespace fire3dv::dataset
