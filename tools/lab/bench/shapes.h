// Shapes of the benchmark scenes with any triangle count: a bumpy sphere and a box with subdivided faces.
// Both are watertight and have texture coordinates and tangents.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/scene/model/scene.h"

namespace fire3dv::bench {

enum class ShapeKind : uint8_t { bumpy_sphere, box };

struct Shape {
  ShapeKind kind = ShapeKind::bumpy_sphere;
  uint32_t rings = 3, columns = 3;  // bumpy sphere
  uint32_t side = 1;                // box: quads per edge
  uint64_t seed = 0;                // of bumps or proportions

  uint32_t triangles() const;
  uint32_t vertices() const;
};

// Returns the shape whose triangle count is nearest to the goal; the error of a sphere is at most its ring
// count.
Shape shape_of(ShapeKind kind, double triangle_goal, uint64_t seed);

// Upper bound of vertex distance from the centre, for all shapes.
constexpr float kMaxShapeRadiusM = 1.4f;

// Output arrays of a shape, sized by vertices() and 3 * triangles().
struct ShapeArrays {
  std::span<glm::vec3> positions;
  std::span<scene::TangentFrame> frames;
  std::span<scene::TangentXy> tangents;
  std::span<glm::vec2> uvs;
  std::span<uint32_t> indices;
};

void make_shape(const Shape& shape, const ShapeArrays& to);

}  // namespace fire3dv::bench
