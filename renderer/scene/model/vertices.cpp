#include "renderer/scene/model/vertices.h"

#include <cmath>
#include <numeric>

namespace fire3dv::scene {
namespace {

template <typename T>
void copy_each(std::vector<T>& values, std::span<const uint32_t> copied) {
  std::vector<T> copies;
  copies.reserve(copied.size());
  for (const uint32_t from : copied) copies.push_back(values[from]);
  values = std::move(copies);
}

}  // namespace

void copy_vertices(Vertices& vertices, std::span<const uint32_t> copied) {
  copy_each(vertices.positions, copied);
  copy_each(vertices.attributes, copied);
  if (vertices.source.empty()) {
    vertices.source.assign(copied.begin(), copied.end());
  } else {
    copy_each(vertices.source, copied);
  }
}

void sanitize_attributes(Vertices& vertices) {
  constexpr float kShortest = 1e-12f;  // squared length; smaller vectors lose their direction when normalised
  for (VertexAttributes& vertex : vertices.attributes) {
    if (!(glm::dot(vertex.normal, vertex.normal) > kShortest)) vertex.normal = VertexAttributes().normal;
    const glm::vec3 tangent(vertex.tangent);
    const glm::vec3 direction =
        glm::dot(tangent, tangent) > kShortest ? tangent : glm::vec3(VertexAttributes().tangent);
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

}  // namespace fire3dv::scene
