#include "renderer/scene/model/vertices.h"

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
    const glm::vec3 kept =
        glm::dot(tangent, tangent) > kShortest ? tangent : glm::vec3(VertexAttributes().tangent);
    vertex.tangent = glm::vec4(kept, vertex.tangent.w < 0 ? -1.0f : 1.0f);
    vertex.color = glm::clamp(vertex.color, 0.0f, 1.0f);
  }
}

}  // namespace fire3dv::scene
