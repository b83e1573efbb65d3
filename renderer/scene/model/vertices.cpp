#include "renderer/scene/model/vertices.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.h"

namespace fire3dv::scene {
namespace {

template <typename T>
void copy_each(std::vector<T>& values, std::span<const uint32_t> copied) {
  std::vector<T> copies;
  copies.reserve(copied.size());
  for (const uint32_t from : copied) copies.push_back(values[from]);
  values = std::move(copies);
}

bool is_identity(std::span<const uint32_t> copied, size_t count) {
  if (copied.size() != count) return false;
  for (size_t v = 0; v < count; ++v)
    if (copied[v] != v) return false;
  return true;
}

}  // namespace

void copy_vertices(Vertices& vertices, std::span<const uint32_t> copied) {
  // Triangles without shared vertices: copies would double the memory of a large mesh.
  if (is_identity(copied, vertices.positions.size())) return;
  copy_each(vertices.positions, copied);
  copy_each(vertices.attributes, copied);
  if (vertices.source.empty()) {
    vertices.source.assign(copied.begin(), copied.end());
  } else {
    copy_each(vertices.source, copied);
  }
}

namespace {

bool has_direction(const glm::vec3& vector) {
  constexpr float kShortest = 1e-12f;  // smaller squares lose their direction when normalised
  const float square = glm::dot(vector, vector);
  return square > kShortest && std::isfinite(square);
}

}  // namespace

size_t repair_normals(Vertices& vertices, std::span<const uint32_t> triangles) {
  const auto& attributes = vertices.attributes;
  if (std::all_of(attributes.begin(), attributes.end(),
                  [](const VertexAttributes& vertex) { return has_direction(vertex.normal); })) {
    return 0;
  }
  std::vector<glm::dvec3> sums(attributes.size(), glm::dvec3(0));
  std::vector<bool> has_triangle(attributes.size(), false);
  for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
    const auto corner = [&](size_t k) { return glm::dvec3(vertices.positions[triangles[i + k]]); };
    const glm::dvec3 cross = glm::cross(corner(1) - corner(0), corner(2) - corner(0));  // weighted by area
    for (size_t k = 0; k < 3; ++k) {
      sums[triangles[i + k]] += cross;
      has_triangle[triangles[i + k]] = true;
    }
  }
  size_t repaired = 0;
  for (size_t v = 0; v < attributes.size(); ++v) {
    glm::vec3& normal = vertices.attributes[v].normal;
    if (has_direction(normal)) continue;
    const double length = glm::length(sums[v]);
    normal = length > 0 && std::isfinite(length) ? glm::vec3(sums[v] / length) : VertexAttributes().normal;
    repaired += has_triangle[v];
  }
  return repaired;
}

void sanitize_attributes(Vertices& vertices) {
  for (VertexAttributes& vertex : vertices.attributes) {
    const glm::vec3 tangent(vertex.tangent);
    const glm::vec3 direction = has_direction(tangent) ? tangent : glm::vec3(VertexAttributes().tangent);
    vertex.tangent = glm::vec4(direction, vertex.tangent.w < 0 ? -1.0f : 1.0f);
    vertex.color = glm::clamp(vertex.color, 0.0f, 1.0f);
  }
}

std::vector<uint32_t> triangles_of_strip(std::span<const uint32_t> strip) {
  std::vector<uint32_t> triangles;
  if (strip.size() < 3) return triangles;
  triangles.reserve((strip.size() - 2) * 3);
  for (size_t i = 0; i + 2 < strip.size(); ++i) {
    // Every second triangle has reversed winding: {i, i + (1 + i % 2), i + (2 - i % 2)}.
    const uint32_t a = strip[i], b = strip[i + 1 + i % 2], c = strip[i + 2 - i % 2];
    if (a != b && b != c && c != a) triangles.insert(triangles.end(), {a, b, c});
  }
  return triangles;
}

std::vector<uint32_t> triangles_of_fan(std::span<const uint32_t> fan) {
  std::vector<uint32_t> triangles;
  if (fan.size() < 3) return triangles;
  triangles.reserve((fan.size() - 2) * 3);
  for (size_t i = 1; i + 1 < fan.size(); ++i) triangles.insert(triangles.end(), {fan[i], fan[i + 1], fan[0]});
  return triangles;
}

std::vector<uint32_t> lines_of_strip(std::span<const uint32_t> strip) {
  std::vector<uint32_t> lines;
  if (strip.size() < 2) return lines;
  lines.reserve(strip.size() * 2);  // including the closing line of a loop
  for (size_t i = 0; i + 1 < strip.size(); ++i) lines.insert(lines.end(), {strip[i], strip[i + 1]});
  return lines;
}

std::vector<uint32_t> lines_of_loop(std::span<const uint32_t> loop) {
  std::vector<uint32_t> lines = lines_of_strip(loop);
  if (!lines.empty()) lines.insert(lines.end(), {loop.back(), loop.front()});
  return lines;
}

void make_flat(Vertices& vertices, std::span<uint32_t> indices) {
  copy_vertices(vertices, indices);
  std::iota(indices.begin(), indices.end(), 0u);
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const glm::vec3& a = vertices.positions[i];
    const glm::vec3 cross = glm::cross(vertices.positions[i + 1] - a, vertices.positions[i + 2] - a);
    const float length = std::sqrt(glm::dot(cross, cross));
    // A degenerate triangle is invisible, but its normal must be finite.
    const glm::vec3 normal = length > 0 && std::isfinite(length) ? cross / length : glm::vec3(0, 0, 1);
    for (size_t corner = i; corner < i + 3; ++corner) vertices.attributes[corner].normal = normal;
  }
}

namespace {

constexpr float kSteps = 32767, kTangentZSteps = 16383, kColorSteps = 65535;

// double, since the square of a small float underflows.
glm::dvec3 unit_or(const glm::dvec3& v, const glm::dvec3& otherwise) {
  const double length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : otherwise;
}

glm::dvec3 unit_tangent(const glm::vec4& tangent) {
  return unit_or(glm::vec3(tangent), {1, 0, 0});
}

int16_t packed(double x) {
  return static_cast<int16_t>(std::lround(x * kSteps));
}

std::array<uint16_t, 4> packed_color(const glm::vec4& color) {
  std::array<uint16_t, 4> packed{};
  for (int i = 0; i < 4; ++i) {
    packed[static_cast<size_t>(i)] =
        static_cast<uint16_t>(std::lround(std::clamp(color[i], 0.0f, 1.0f) * kColorSteps));
  }
  return packed;
}

VertexExtras extras_of(const VertexAttributes& attributes) {
  return {attributes.uv1, packed_color(attributes.color)};
}

template <typename Test>
bool any(std::span<const VertexAttributes> attributes, const Test& test) {
  return std::any_of(attributes.begin(), attributes.end(), test);
}

}  // namespace

TangentFrame packed_frame(const glm::vec3& normal, const glm::vec4& tangent) {
  const glm::dvec3 n = unit_or(normal, {0, 0, 1});
  const auto z = static_cast<int>(std::lround(unit_tangent(tangent).z * kTangentZSteps));
  return {{packed(n.x), packed(n.y), packed(n.z)}, static_cast<int16_t>(2 * z + (tangent.w < 0 ? 0 : 1))};
}

TangentXy packed_tangent(const glm::vec4& tangent) {
  const glm::dvec3 t = unit_tangent(tangent);
  return {packed(t.x), packed(t.y)};
}

glm::vec3 normal_of(const TangentFrame& frame) {
  return glm::vec3(frame.normal[0], frame.normal[1], frame.normal[2]) / kSteps;
}

glm::vec4 tangent_of(const Scene& scene, uint32_t v) {
  const TangentXy xy = scene.tangents.empty() ? kNoTangent : scene.tangents[v];
  const int z = scene.frames[v].tangent_z;
  return {static_cast<float>(xy[0]) / kSteps, static_cast<float>(xy[1]) / kSteps,
          static_cast<float>(z >> 1) / kTangentZSteps, (z & 1) != 0 ? 1.0f : -1.0f};
}

VertexAttributes attributes_of(const Scene& scene, uint32_t v) {
  VertexAttributes attributes;
  attributes.tangent = tangent_of(scene, v);
  attributes.normal = normal_of(scene.frames[v]);
  attributes.uv0 = scene.uvs[v];
  if (scene.extras.empty()) return attributes;
  attributes.uv1 = scene.extras[v].uv1;
  const auto& color = scene.extras[v].color;
  attributes.color = glm::vec4(color[0], color[1], color[2], color[3]) / kColorSteps;
  return attributes;
}

bool has_color(const Scene& scene, uint32_t v) {
  return !scene.extras.empty() && scene.extras[v].color != VertexExtras().color;
}

void append_attributes(Scene& scene, std::span<const VertexAttributes> attributes) {
  constexpr size_t kTurn = 1 << 14;
  const size_t first = scene.frames.size(), count = attributes.size();
  const VertexAttributes plain;
  const bool tangents = !scene.tangents.empty() || any(attributes, [&](const VertexAttributes& a) {
    return glm::vec3(a.tangent) != glm::vec3(plain.tangent);
  });
  const bool extras = !scene.extras.empty() || any(attributes, [&](const VertexAttributes& a) {
    return a.uv1 != plain.uv1 || a.color != plain.color;
  });
  if (tangents) scene.tangents.resize(first, kNoTangent);
  if (extras) scene.extras.resize(first);
  if (tangents) scene.tangents.resize(first + count);
  scene.frames.resize(first + count);
  scene.uvs.resize(first + count);
  if (extras) scene.extras.resize(first + count);
  parallel_for((count + kTurn - 1) / kTurn, [&](size_t turn) {
    for (size_t i = turn * kTurn; i < std::min(count, (turn + 1) * kTurn); ++i) {
      const VertexAttributes& from = attributes[i];
      scene.frames[first + i] = packed_frame(from.normal, from.tangent);
      scene.uvs[first + i] = from.uv0;
      if (tangents) scene.tangents[first + i] = packed_tangent(from.tangent);
      if (extras) scene.extras[first + i] = extras_of(from);
    }
  });
}

}  // namespace fire3dv::scene
