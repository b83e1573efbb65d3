// Quadric error metrics: sums of squared distances to planes and of attribute differences (Garland and
// Heckbert 1997; Hoppe 1999). Double precision, since distances on finely tessellated smooth surfaces are a
// millionth of the coordinates.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>

namespace fire3dv::scene {

struct Quadric {
  glm::dmat3 a{0};  // symmetric
  glm::dvec3 b{0};
  double c = 0, weight = 0;

  // Adds (dot(normal, p) + d)^2.
  void add_plane(const glm::dvec3& normal, double d, double plane_weight) {
    a += plane_weight * glm::outerProduct(normal, normal);
    b += plane_weight * d * normal;
    c += plane_weight * d * d;
    weight += plane_weight;
  }
  void add(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    weight += other.weight;
  }
  double at(const glm::dvec3& p) const { return glm::dot(p, a * p) + 2 * glm::dot(b, p) + c; }
};

// Normal and texture coordinates, scaled to lengths of equal visual importance.
constexpr size_t kAttributeCount = 5;
using AttributeValues = std::array<double, kAttributeCount>;

struct AttributeQuadric {
  Quadric values;
  std::array<glm::dvec4, kAttributeCount> gradients{};
  double squares_weight = 0;

  void add_triangle(const std::array<glm::dvec3, 3>& p, const std::array<AttributeValues, 3>& s,
                    double weight) {
    const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double n2 = glm::dot(n, n);
    if (!(n2 > 0)) return;
    const glm::dvec3 along[3] = {glm::cross(n, p[2] - p[1]) / n2, glm::cross(n, p[0] - p[2]) / n2,
                                 glm::cross(n, p[1] - p[0]) / n2};
    for (size_t k = 0; k < kAttributeCount; ++k) {
      const glm::dvec3 g = s[0][k] * along[0] + s[1][k] * along[1] + s[2][k] * along[2];
      const double d = s[0][k] - glm::dot(g, p[0]);
      values.add_plane(g, d, weight);
      gradients[k] += weight * glm::dvec4(g, d);
    }
    squares_weight += weight;
  }
  void add(const AttributeQuadric& other) {
    values.add(other.values);
    for (size_t k = 0; k < kAttributeCount; ++k) gradients[k] += other.gradients[k];
    squares_weight += other.squares_weight;
  }
  double at(const glm::dvec3& p, const AttributeValues& s) const {
    double sum = values.at(p);
    for (size_t k = 0; k < kAttributeCount; ++k) {
      sum += s[k] * (squares_weight * s[k] - 2 * (glm::dot(glm::dvec3(gradients[k]), p) + gradients[k].w));
    }
    return sum;
  }
};

}  // namespace fire3dv::scene
