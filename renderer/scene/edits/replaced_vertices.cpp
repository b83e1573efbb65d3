#include "renderer/scene/edits/replaced_vertices.h"

#include <cmath>
#include <span>

#include "renderer/scene/model/bounds.h"
#include "renderer/scene/model/packed_vertices.h"

namespace fire3dv::scene {
namespace {

uint32_t file_count(const Primitive& primitive) {
  return primitive.first_vertex_source == kNone ? primitive.vertex_count : primitive.file_vertex_count;
}

// File index of a vertex of the primitive.
uint32_t file_vertex(const Scene& scene, const Primitive& primitive, uint32_t vertex) {
  return primitive.first_vertex_source == kNone
             ? vertex
             : scene.vertex_sources[primitive.first_vertex_source + vertex];
}

// True if each corner has its own vertex: the file has no normals, and glTF requires flat ones.
bool is_flat(const Primitive& primitive) {
  return primitive.first_vertex_source != kNone && primitive.vertex_count == primitive.index_count;
}

// Area-weighted vertex normals; flat normals for flat primitives.
std::vector<glm::vec3> normals_of(const Scene& scene, const Primitive& primitive,
                                  std::span<const glm::vec3> positions) {
  const bool flat = is_flat(primitive);
  const auto place = [&](uint32_t vertex) { return flat ? vertex : file_vertex(scene, primitive, vertex); };
  std::vector<glm::vec3> sums(flat ? primitive.vertex_count : file_count(primitive), glm::vec3(0));
  const uint32_t corners = primitive.topology == Topology::triangles ? primitive.index_count / 3 * 3 : 0;
  for (uint32_t i = 0; i < corners; i += 3) {
    const uint32_t* const corner = &scene.indices[primitive.first_index + i];
    const glm::vec3& a = positions[corner[0]];
    const glm::vec3 area = glm::cross(positions[corner[1]] - a, positions[corner[2]] - a);
    for (int c = 0; c < 3; ++c) sums[place(corner[c])] += area;
  }
  std::vector<glm::vec3> normals(primitive.vertex_count);
  for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
    const glm::vec3& sum = sums[place(v)];
    const float length = glm::length(sum);
    // Vertices without a non-degenerate triangle keep the file's normal.
    normals[v] = length > 0 && std::isfinite(length) ? sum / length
                                                     : normal_of(scene.frames[primitive.first_vertex + v]);
  }
  return normals;
}

void find_sphere(PosedVertices& posed) {
  Box box;
  for (const glm::vec3& position : posed.positions) box.add(position);
  if (!box.empty())
    posed.sphere = glm::vec4(0.5f * box.low + 0.5f * box.high, 0.5001f * glm::length(box.high - box.low));
}

std::span<const Primitive> primitives_of(const Scene& scene, const Mesh& mesh) {
  return std::span(scene.primitives).subspan(mesh.first_primitive, mesh.primitive_count);
}

}  // namespace

bool can_replace_vertices(const Node& node) {
  return node.mesh != kNone && node.skin == kNone && node.morph_weight_count == 0;
}

uint64_t file_vertex_count(const Scene& scene, const Mesh& mesh) {
  uint64_t count = 0;
  for (const Primitive& primitive : primitives_of(scene, mesh)) count += file_count(primitive);
  return count;
}

PosedVertices pose_vertices(const Scene& scene, const Mesh& mesh, const ReplacedVertices& replaced) {
  PosedVertices posed;
  size_t first_file_vertex = 0;
  for (const Primitive& primitive : primitives_of(scene, mesh)) {
    const size_t first = posed.positions.size();
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      const size_t from = first_file_vertex + file_vertex(scene, primitive, v);
      posed.positions.push_back(replaced.positions[from]);
      if (replaced.normals.empty()) continue;
      const float length = glm::length(replaced.normals[from]);
      posed.normals.push_back(length > 0 && std::isfinite(length)
                                  ? replaced.normals[from] / length
                                  : normal_of(scene.frames[primitive.first_vertex + v]));
    }
    if (replaced.normals.empty()) {
      const std::vector<glm::vec3> normals =
          normals_of(scene, primitive, std::span(posed.positions).subspan(first));
      posed.normals.insert(posed.normals.end(), normals.begin(), normals.end());
    }
    first_file_vertex += file_count(primitive);
  }
  find_sphere(posed);
  return posed;
}

PosedVertices rest_vertices(const Scene& scene, const Mesh& mesh) {
  PosedVertices posed;
  for (const Primitive& primitive : primitives_of(scene, mesh)) {
    for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + primitive.vertex_count; ++v) {
      posed.positions.push_back(scene.positions[v]);
      posed.normals.push_back(normal_of(scene.frames[v]));
    }
  }
  find_sphere(posed);
  return posed;
}

}  // namespace fire3dv::scene
