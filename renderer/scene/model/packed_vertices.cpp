#include "renderer/scene/model/packed_vertices.h"

#include <algorithm>
#include <cmath>

#include "protocol/base/parallel.h"

namespace fire3dv::scene {
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
