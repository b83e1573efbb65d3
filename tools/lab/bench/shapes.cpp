#include "tools/lab/bench/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "protocol/base/error.h"
#include "renderer/scene/model/packed_vertices.h"
#include "tools/lab/bench/random.h"

namespace fire3dv::bench {
namespace {

constexpr float kPi = 3.14159265f;
constexpr glm::vec2 kSphereRepeat(4, 2);
constexpr float kBoxRepeat = 2;

// Sphere displaced by three waves: radius and surface normal by direction.
struct Bumps {
  std::array<glm::vec3, 3> wave;
  std::array<float, 3> phase, height;

  explicit Bumps(uint64_t seed) {
    Random random(seed);
    constexpr float kFrequencies[] = {3, 6, 11};
    for (size_t i = 0; i < 3; ++i) {
      wave[i] = random.direction() * kFrequencies[i];
      phase[i] = random.uniform(0, 2 * kPi);
      height[i] = 0.16f / kFrequencies[i];
    }
  }

  void at(const glm::vec3& direction, glm::vec3& position, glm::vec3& normal) const {
    float radius = 1;
    glm::vec3 slope(0);
    for (size_t i = 0; i < 3; ++i) {
      const float angle = glm::dot(direction, wave[i]) + phase[i];
      radius += height[i] * std::sin(angle);
      slope += height[i] * std::cos(angle) * wave[i];
    }
    slope -= glm::dot(slope, direction) * direction;
    position = direction * radius;
    normal = glm::normalize(direction * radius - slope);
  }
};

void set_vertex(const ShapeArrays& to, size_t vertex, const glm::vec3& normal, const glm::vec3& along_u,
                const glm::vec2& uv) {
  const glm::vec4 tangent(along_u - glm::dot(along_u, normal) * normal,
                          -1);  // v runs downwards on both shapes
  to.frames[vertex] = scene::packed_frame(normal, tangent);
  to.tangents[vertex] = scene::packed_tangent(tangent);
  to.uvs[vertex] = uv;
}

void make_bumpy_sphere(const Shape& shape, const ShapeArrays& to) {
  const Bumps bumps(shape.seed);
  const uint32_t rings = shape.rings, columns = shape.columns;
  size_t vertex = 0;
  const auto add = [&](float theta, float phi, const glm::vec2& uv) {
    const glm::vec3 direction(std::sin(theta) * std::cos(phi), std::cos(theta),
                              std::sin(theta) * std::sin(phi));
    glm::vec3 normal;
    bumps.at(direction, to.positions[vertex], normal);
    set_vertex(to, vertex++, normal, glm::vec3(-std::sin(phi), 0, std::cos(phi)), uv * kSphereRepeat);
  };
  // The last vertex of a ring duplicates the first with the other texture coordinate.
  for (uint32_t r = 1; r < rings; ++r) {
    const float v = static_cast<float>(r) / static_cast<float>(rings);
    const size_t first = vertex;
    for (uint32_t c = 0; c < columns; ++c) {
      const float u = static_cast<float>(c) / static_cast<float>(columns);
      add(v * kPi, u * 2 * kPi, {u, v});
    }
    to.positions[vertex] = to.positions[first];
    to.frames[vertex] = to.frames[first];
    to.tangents[vertex] = to.tangents[first];
    to.uvs[vertex] = {kSphereRepeat.x, to.uvs[first].y};
    ++vertex;
  }
  // Poles share one position, with one vertex per triangle.
  for (const bool south : {false, true}) {
    const size_t first = vertex;
    for (uint32_t c = 0; c < columns; ++c) {
      const float u = (static_cast<float>(c) + 0.5f) / static_cast<float>(columns);
      add(south ? kPi : 0, u * 2 * kPi, {u, south ? 1 : 0});
      to.positions[vertex - 1] = to.positions[first];
    }
  }

  size_t index = 0;
  const auto triangle = [&](uint32_t a, uint32_t b, uint32_t c) {
    to.indices[index++] = a;
    to.indices[index++] = b;
    to.indices[index++] = c;
  };
  const uint32_t row = columns + 1, north = (rings - 1) * row, south = north + columns;
  for (uint32_t c = 0; c < columns; ++c) triangle(north + c, c + 1, c);
  for (uint32_t r = 0; r + 2 < rings; ++r) {
    for (uint32_t c = 0; c < columns; ++c) {
      const uint32_t upper = r * row + c, lower = upper + row;
      triangle(upper, upper + 1, lower);
      triangle(upper + 1, lower + 1, lower);
    }
  }
  const uint32_t last = (rings - 2) * row;
  for (uint32_t c = 0; c < columns; ++c) triangle(last + c, last + c + 1, south + c);
  FIRE3DV_ASSERT(vertex == to.positions.size() && index == to.indices.size());
}

void make_box(const Shape& shape, const ShapeArrays& to) {
  Random random(shape.seed);
  const float x = random.uniform(0.5f, 0.8f), y = random.uniform(0.5f, 0.8f), z = random.uniform(0.5f, 0.8f);
  const glm::vec3 half(x, y, z);
  const uint32_t side = shape.side, row = side + 1;
  // One expression for all faces, so that shared edges are bit-identical.
  const auto along = [&](uint32_t i) { return 2 * static_cast<float>(i) / static_cast<float>(side) - 1; };
  size_t vertex = 0, index = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {1.0f, -1.0f}) {
      int first = (axis + 1) % 3, second = (axis + 2) % 3;
      if (sign < 0) std::swap(first, second);
      glm::vec3 normal(0), along_u(0);
      normal[axis] = sign;
      along_u[first] = 1;
      const auto base = static_cast<uint32_t>(vertex);
      for (uint32_t i = 0; i < row; ++i) {
        for (uint32_t j = 0; j < row; ++j) {
          glm::vec3 corner;
          corner[axis] = sign;
          corner[first] = along(i);
          corner[second] = along(j);
          to.positions[vertex] = corner * half;
          set_vertex(to, vertex++, normal, along_u,
                     (glm::vec2(corner[first], corner[second]) * 0.5f + 0.5f) * kBoxRepeat);
        }
      }
      for (uint32_t i = 0; i < side; ++i) {
        for (uint32_t j = 0; j < side; ++j) {
          const uint32_t a = base + i * row + j;
          for (const uint32_t corner : {a, a + row, a + row + 1, a, a + row + 1, a + 1})
            to.indices[index++] = corner;
        }
      }
    }
  }
  FIRE3DV_ASSERT(vertex == to.positions.size() && index == to.indices.size());
}

}  // namespace

uint32_t Shape::triangles() const {
  return kind == ShapeKind::box ? 12 * side * side : 2 * columns * (rings - 1);
}

uint32_t Shape::vertices() const {
  return kind == ShapeKind::box ? 6 * (side + 1) * (side + 1) : (rings - 1) * (columns + 1) + 2 * columns;
}

Shape shape_of(ShapeKind kind, double triangle_goal, uint64_t seed) {
  Shape shape;
  shape.kind = kind;
  shape.seed = seed;
  const auto at_least = [](double value, double least) {
    return static_cast<uint32_t>(std::max(least, std::round(value)));
  };
  const double goal = std::max(triangle_goal, 1.0);
  shape.side = at_least(std::sqrt(goal / 12), 1);
  shape.rings = at_least((1 + std::sqrt(1 + goal)) / 2, 3);
  shape.columns = at_least(goal / (2.0 * (shape.rings - 1)), 3);
  return shape;
}

void make_shape(const Shape& shape, const ShapeArrays& to) {
  if (shape.kind == ShapeKind::box) return make_box(shape, to);
  make_bumpy_sphere(shape, to);
}

}  // namespace fire3dv::bench
