#include "renderer/scene/packed_vertices.h"

#include <algorithm>
#include <cmath>

#include "renderer/scene/parallel.h"

namespace fire3dv::scene {
namespace {

constexpr float kNormalSteps = 32767, kColorSteps = 65535;
constexpr float kTangentSteps = 8192;  // along each side of the square
constexpr uint32_t kTangentMask = 0x7fff;

struct Basis {
  glm::vec3 x, y;
};

Basis basis_around(const TangentFrame& frame) {
  const glm::vec3 n = normal_of(frame);
  const float sign = frame.normal[2] >= 0 ? 1.0f : -1.0f;
  const float a = -1 / (sign + n.z), b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
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

}  // namespace

TangentFrame packed_frame(const glm::vec3& normal, const glm::vec4& tangent) {
  TangentFrame frame;
  const glm::dvec3 any_length(normal);  // whose square is no float's
  const double length = glm::length(any_length);
  if (length > 0 && std::isfinite(length)) {
    for (int i = 0; i < 3; ++i) {
      frame.normal[static_cast<size_t>(i)] =
          static_cast<int16_t>(std::lround(any_length[i] / length * kNormalSteps));
    }
  }
  const Basis basis = basis_around(frame);
  const float x = glm::dot(basis.x, glm::vec3(tangent)), y = glm::dot(basis.y, glm::vec3(tangent));
  const float sum = std::abs(x) + std::abs(y);
  uint32_t place = 0;
  if (sum > 0 && std::isfinite(sum)) {
    const float along = y >= 0 ? 1 - x / sum : 3 + x / sum;
    place = static_cast<uint32_t>(std::lround(along * kTangentSteps)) & kTangentMask;
  }
  frame.tangent = static_cast<uint16_t>(place << 1 | (tangent.w < 0 ? 0 : 1));
  return frame;
}

glm::vec3 normal_of(const TangentFrame& frame) {
  return glm::vec3(frame.normal[0], frame.normal[1], frame.normal[2]) / kNormalSteps;
}

glm::vec4 tangent_of(const TangentFrame& frame) {
  const float along = static_cast<float>(frame.tangent >> 1) / kTangentSteps;
  const float x = along <= 2 ? 1 - along : along - 3;
  const float y = along <= 2 ? 1 - std::abs(1 - along) : std::abs(along - 3) - 1;
  const Basis basis = basis_around(frame);
  return {glm::normalize(basis.x * x + basis.y * y), (frame.tangent & 1) != 0 ? 1.0f : -1.0f};
}

VertexAttributes attributes_of(const Scene& scene, uint32_t v) {
  VertexAttributes attributes;
  attributes.tangent = tangent_of(scene.frames[v]);
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
  const bool more = std::any_of(attributes.begin(), attributes.end(),
                                [](const VertexAttributes& a) { return extras_of(a) != VertexExtras(); });
  if (more) scene.extras.resize(first);
  const bool extras = more || !scene.extras.empty();
  scene.frames.resize(first + count);
  scene.uvs.resize(first + count);
  if (extras) scene.extras.resize(first + count);
  parallel_for((count + kTurn - 1) / kTurn, [&](size_t turn) {
    for (size_t i = turn * kTurn; i < std::min(count, (turn + 1) * kTurn); ++i) {
      const VertexAttributes& from = attributes[i];
      scene.frames[first + i] = packed_frame(from.normal, from.tangent);
      scene.uvs[first + i] = from.uv0;
      if (extras) scene.extras[first + i] = extras_of(from);
    }
  });
}

}  // namespace fire3dv::scene
