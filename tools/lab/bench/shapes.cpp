#include "tools/lab/bench/shapes.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "renderer/scene/model/vertices.h"

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

namespace {

constexpr uint32_t kSets = 8;
constexpr uint32_t kTexturesOfSet = 3;

// Tileable smooth noise from 0 to 1.
class Noise {
 public:
  explicit Noise(uint64_t seed) {
    Random random(seed);
    for (float& value : values_) value = random.uniform(0, 1);
  }

  float at(float u, float v, uint32_t cells) const {
    const float x = u * static_cast<float>(cells), y = v * static_cast<float>(cells);
    const float fx = std::floor(x), fy = std::floor(y);
    const auto ix = static_cast<uint32_t>(fx), iy = static_cast<uint32_t>(fy);
    const float tx = ease(x - fx), ty = ease(y - fy);
    return glm::mix(glm::mix(value(ix, iy, cells), value(ix + 1, iy, cells), tx),
                    glm::mix(value(ix, iy + 1, cells), value(ix + 1, iy + 1, cells), tx), ty);
  }

 private:
  static constexpr uint32_t kSide = 64;
  static float ease(float t) { return t * t * (3 - 2 * t); }
  float value(uint32_t x, uint32_t y, uint32_t cells) const {
    return values_[(y % cells) % kSide * kSide + (x % cells) % kSide];
  }
  float values_[kSide * kSide];
};

// Texture set: panels with grooves and uneven wear.
struct Pattern {
  Noise noise;
  uint32_t panels;

  explicit Pattern(uint32_t set) : noise(1000 + set), panels(2 + set % 4) {}

  float wear(float u, float v) const { return 0.6f * noise.at(u, v, 8) + 0.4f * noise.at(u, v, 32); }
  float height(float u, float v) const {
    const float n = static_cast<float>(panels);
    const glm::vec2 in_panel(u * n - std::floor(u * n), v * n - std::floor(v * n));
    const glm::vec2 from_edge = glm::min(in_panel, 1.0f - in_panel);
    const float groove = glm::smoothstep(0.02f, 0.08f, std::min(from_edge.x, from_edge.y));
    return groove * 0.02f + 0.004f * wear(u, v);
  }

  glm::vec4 base_color(float u, float v) const {
    const float groove = glm::smoothstep(0.0f, 0.02f, height(u, v));
    const float light = glm::mix(0.35f, 1.0f, groove) * (0.75f + 0.25f * wear(u, v));
    return glm::vec4(glm::vec3(light), 1);
  }
  glm::vec4 normal(float u, float v, float texel) const {
    const float du =
        (height(u + texel, v) - height(u - texel < 0 ? u - texel + 1 : u - texel, v)) / (2 * texel);
    const float dv =
        (height(u, v + texel) - height(u, v - texel < 0 ? v - texel + 1 : v - texel)) / (2 * texel);
    const glm::vec3 n = glm::normalize(glm::vec3(-du, dv, 1));  // green points up, v runs downwards
    return glm::vec4(n * 0.5f + 0.5f, 1);
  }
  glm::vec4 metallic_roughness(float u, float v) const { return {1, 0.6f + 0.4f * wear(u, v), 1, 1}; }
};

void paint(scene::Image& image, uint32_t side, const std::function<glm::vec4(float, float)>& texel) {
  image.width = image.height = side;
  image.rgba8.edit().resize(size_t{4} * side * side);
  uint8_t* out = image.rgba8.edit().data();
  for (uint32_t y = 0; y < side; ++y) {
    for (uint32_t x = 0; x < side; ++x) {
      const glm::vec4 value = texel((static_cast<float>(x) + 0.5f) / static_cast<float>(side),
                                    (static_cast<float>(y) + 0.5f) / static_cast<float>(side));
      for (int c = 0; c < 4; ++c)
        *out++ = static_cast<uint8_t>(glm::clamp(value[c], 0.0f, 1.0f) * 255.0f + 0.5f);
    }
  }
}

void paint_texture(uint32_t number, uint32_t side, scene::Image& image) {
  const Pattern pattern(number / kTexturesOfSet);
  const std::string set = std::to_string(number / kTexturesOfSet);
  const float texel = 1 / static_cast<float>(side);
  switch (number % kTexturesOfSet) {
    case 0:
      image.name = "base_color_" + set;
      return paint(image, side, [&](float u, float v) { return pattern.base_color(u, v); });
    case 1:
      image.name = "normal_" + set;
      return paint(image, side, [&](float u, float v) { return pattern.normal(u, v, texel); });
    default:
      image.name = "metallic_roughness_" + set;
      return paint(image, side, [&](float u, float v) { return pattern.metallic_roughness(u, v); });
  }
}

}  // namespace

Surfaces make_surfaces(uint32_t side) {
  Surfaces surfaces;
  if (side > 0) {
    surfaces.images.resize(size_t{kSets} * kTexturesOfSet);
    parallel_for(surfaces.images.size(),
                 [&](size_t i) { paint_texture(static_cast<uint32_t>(i), side, surfaces.images[i]); });
    for (uint32_t i = 0; i < surfaces.images.size(); ++i)
      surfaces.textures.push_back({i, {}, i % kTexturesOfSet == 0});
  }

  surfaces.materials.resize(2);
  scene::Material& ground = surfaces.materials[1];
  ground.name = "ground";
  ground.base_color = {0.45f, 0.45f, 0.45f, 1};
  ground.metallic = 0;
  ground.roughness = 0.9f;
  Random random(1);
  for (uint32_t m = 0; m < kMaterials; ++m) {
    scene::Material material;
    material.name = "material_" + std::to_string(m);
    for (int c = 0; c < 3; ++c) material.base_color[c] = random.uniform(0.15f, 0.95f);
    material.metallic = m % 4 == 3 ? 1.0f : 0.0f;
    material.roughness = random.uniform(0.2f, 0.8f);
    if (side > 0) {
      const uint32_t first = m % kSets * kTexturesOfSet;
      material.base_color_texture.texture = first;
      material.normal_texture.texture = first + 1;
      material.metallic_roughness_texture.texture = first + 2;
    }
    surfaces.materials.push_back(material);
  }
  return surfaces;
}

}  // namespace fire3dv::bench
