// The two shapes of the benchmark's scenes, of any number of triangles: a sphere with bumps and a box whose
// faces are subdivided. Both are closed, and both have texture coordinates and tangents.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/scene/scene.h"

namespace fire3dv::bench {

enum class ShapeKind : uint8_t { bumpy_sphere, box };

struct Shape {
  ShapeKind kind = ShapeKind::bumpy_sphere;
  uint32_t rings = 3, columns = 3;  // bumpy sphere
  uint32_t side = 1;                // box: quads along an edge
  uint64_t seed = 0;                // of its bumps, or its proportions

  uint32_t triangles() const;
  uint32_t vertices() const;
};

// The shape whose number of triangles is nearest to the goal; a sphere misses it by at most its rings.
Shape shape_of(ShapeKind kind, double triangle_goal, uint64_t seed);

// No vertex of any shape is farther from its centre.
constexpr float kMostShapeRadiusM = 1.4f;

// Of a shape's vertices, and its corners; of the sizes that it says.
struct ShapeArrays {
  std::span<glm::vec3> positions;
  std::span<scene::TangentFrame> frames;
  std::span<scene::TangentXy> tangents;
  std::span<glm::vec2> uvs;
  std::span<uint32_t> indices;
};

void make_shape(const Shape& shape, const ShapeArrays& to);

}  // namespace fire3dv::bench
