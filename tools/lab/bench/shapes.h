// Shapes and materials of the benchmark scenes. A bumpy sphere and a box with subdivided faces have any
// triangle count; both are watertight and have texture coordinates and tangents.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::bench {

// Portable random numbers (SplitMix64): distributions of the standard library differ between implementations.
// Each generated object has its own seed, so that the order of generation does not matter.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t bits() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  float uniform(float low, float high) {
    return low + (high - low) * static_cast<float>(static_cast<double>(bits() >> 11) * 0x1p-53);
  }
  glm::vec3 direction() {
    const float y = uniform(-1, 1), phi = uniform(0, 6.28318531f);
    const float r = std::sqrt(std::max(0.0f, 1 - y * y));
    return {r * std::cos(phi), y, r * std::sin(phi)};
  }

 private:
  uint64_t state_;
};

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

// Procedural materials of the benchmark scenes: 32 colours over eight texture sets (base colour, normal,
// metallic-roughness).

constexpr uint32_t kMaterials = 32;  // without the ground's

struct Surfaces {
  std::vector<scene::Image> images;
  std::vector<scene::Texture> textures;
  std::vector<scene::Material> materials;  // [0] default, [1] ground, then bodies
};

// side: texture size in pixels; 0: no textures.
Surfaces make_surfaces(uint32_t side);

}  // namespace fire3dv::bench
