#include "convert/mesh/mesh_store.h"

#include <bit>
#include <cmath>
#include <string_view>
#include <utility>

namespace fire3dv::convert {

namespace {

// Bounds shapes, since adding one searches the mesh's surfaces.
constexpr size_t kMaxShapes = 100'000;

size_t triangles_of(const Mesh& mesh) {
  size_t triangles = 0;
  for (const Surface& surface : mesh.surfaces) triangles += surface.indices.size() / 3;
  return triangles;
}

template <typename T>
void mix(uint64_t& hash, const std::vector<T>& values) {
  const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  hash = (hash ^ std::hash<std::string_view>()(bytes)) * 0x9e3779b97f4a7c15ull;
}

uint64_t hash_of(const Mesh& mesh) {
  uint64_t hash = mesh.surfaces.size();
  for (const Surface& surface : mesh.surfaces) {
    mix(hash, surface.positions);
    mix(hash, surface.indices);
    hash ^= surface.material;
  }
  return hash;
}

}  // namespace

bool MeshStore::take_shape(const Mesh& so_far) {
  if (shapes_ <= kMaxShapes) ++shapes_;
  return shapes_ <= kMaxShapes && triangles_ + triangles_of(so_far) <= max_triangles_;
}

std::string MeshStore::why_full() const {
  return shapes_ > kMaxShapes ? "there are more than " + std::to_string(kMaxShapes) + " shapes"
                              : "the scene has more than " + std::to_string(max_triangles_) + " triangles";
}

std::optional<size_t> MeshStore::add(Mesh mesh) {
  if (mesh.surfaces.empty()) return std::nullopt;
  const uint64_t hash = hash_of(mesh);
  const auto [first, last] = by_hash_.equal_range(hash);
  for (auto known = first; known != last; ++known)
    if (model_.meshes[known->second].unbounded == mesh.unbounded &&
        model_.meshes[known->second].surfaces == mesh.surfaces)
      return known->second;
  triangles_ += triangles_of(mesh);
  for (Surface& surface : mesh.surfaces) {
    surface.positions.shrink_to_fit();
    surface.normals.shrink_to_fit();
    surface.uvs.shrink_to_fit();
    surface.colors.shrink_to_fit();
    surface.indices.shrink_to_fit();
    surface.influences.shrink_to_fit();
  }
  by_hash_.emplace(hash, model_.meshes.size());
  model_.meshes.push_back(std::move(mesh));
  return model_.meshes.size() - 1;
}

namespace {

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

uint64_t mixed(uint64_t hash, float value) {
  return (hash ^ std::bit_cast<uint32_t>(value)) * 0x9e3779b97f4a7c15ull;
}

uint64_t hash_of(const SurfaceBuilder::Corner& c) {
  uint64_t hash = 0;
  for (const float f : {c.position.x, c.position.y, c.position.z, c.normal.x, c.normal.y, c.normal.z, c.uv.x,
                        c.uv.y, c.color.r, c.color.g, c.color.b, c.color.a}) {
    hash = mixed(hash, f);
    hash ^= hash >> 29;
  }
  return hash;
}

bool unit_length(glm::vec3& normal) {
  const glm::dvec3 wide(normal);
  const double length = glm::length(wide);
  if (!(length > 1e-20) || !std::isfinite(length)) return false;
  normal = glm::vec3(wide / length);
  return true;
}

}  // namespace

bool SurfaceBuilder::add(const Corner& a, const Corner& b, const Corner& c) {
  if (!finite(a.position) || !finite(b.position) || !finite(c.position)) return false;
  Corner corners[] = {a, b, c};
  if (normals_) {
    glm::vec3 flat(glm::cross(glm::dvec3(b.position) - glm::dvec3(a.position),
                              glm::dvec3(c.position) - glm::dvec3(a.position)));
    if (!unit_length(flat)) flat = {0, 0, 1};  // degenerate triangle, never visible
    for (Corner& corner : corners)
      if (!unit_length(corner.normal)) corner.normal = flat;
  }
  for (const Corner& corner : corners) surface_.indices.push_back(vertex(corner));
  return true;
}

uint32_t SurfaceBuilder::vertex(const Corner& corner) {
  if (surface_.positions.size() * 2 >= table_.size()) grow();
  const size_t mask = table_.size() - 1;
  for (size_t slot = hash_of(corner) & mask;; slot = (slot + 1) & mask) {
    const uint32_t known = table_[slot];
    if (known == 0) {
      surface_.positions.push_back(corner.position);
      if (normals_) surface_.normals.push_back(corner.normal);
      if (uvs_) surface_.uvs.push_back(corner.uv);
      if (colors_) surface_.colors.push_back(corner.color);
      return (table_[slot] = static_cast<uint32_t>(surface_.positions.size())) - 1;
    }
    const uint32_t v = known - 1;
    if (surface_.positions[v] == corner.position && (!normals_ || surface_.normals[v] == corner.normal) &&
        (!uvs_ || surface_.uvs[v] == corner.uv) && (!colors_ || surface_.colors[v] == corner.color)) {
      return v;
    }
  }
}

void SurfaceBuilder::grow() {
  table_.assign(std::max<size_t>(64, table_.size() * 2), 0);
  const size_t mask = table_.size() - 1;
  for (uint32_t v = 0; v < surface_.positions.size(); ++v) {
    const Corner corner{surface_.positions[v], normals_ ? surface_.normals[v] : glm::vec3(0),
                        uvs_ ? surface_.uvs[v] : glm::vec2(0), colors_ ? surface_.colors[v] : glm::vec4(1)};
    size_t slot = hash_of(corner) & mask;
    while (table_[slot] != 0) slot = (slot + 1) & mask;
    table_[slot] = v + 1;
  }
}

Surface SurfaceBuilder::take() {
  table_.clear();
  return std::exchange(surface_, {});
}

}  // namespace fire3dv::convert
