#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "renderer/dataset/randomize/settle.h"

namespace fire3dv::dataset {
namespace {

// Spread evenly over the sphere (a Fibonacci lattice), behind the axes and the corners of a cube.
std::vector<glm::vec3> make_directions() {
  std::vector<glm::vec3> directions;
  for (int i = 0; i < 3; ++i) {
    for (const float sign : {-1.0f, 1.0f}) {
      glm::vec3 axis(0);
      axis[i] = sign;
      directions.push_back(axis);
    }
  }
  for (int i = 0; i < 8; ++i)
    directions.push_back(glm::normalize(glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  const size_t rest = kMaxHullPoints - directions.size();
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (size_t i = 0; i < rest; ++i) {
    const double y = 1 - 2 * (static_cast<double>(i) + 0.5) / static_cast<double>(rest);
    const double radius = std::sqrt(1 - y * y), angle = turn * static_cast<double>(i);
    directions.emplace_back(radius * std::cos(angle), y, radius * std::sin(angle));
  }
  return directions;
}

}  // namespace

Hull hull_of(std::span<const glm::vec3> points) {
  static const std::vector<glm::vec3> directions = make_directions();
  std::set<size_t> corners;
  for (const glm::vec3& direction : directions) {
    size_t farthest = 0;
    float most = -INFINITY;
    for (size_t i = 0; i < points.size(); ++i) {
      const float along = glm::dot(direction, points[i]);
      if (!(along > most)) continue;
      most = along;
      farthest = i;
    }
    if (most > -INFINITY) corners.insert(farthest);
  }
  Hull hull;
  for (const size_t corner : corners) hull.push_back(points[corner]);
  return hull;
}

}  // namespace fire3dv::dataset
