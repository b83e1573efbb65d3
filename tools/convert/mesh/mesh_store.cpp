#include "tools/convert/mesh/mesh_store.h"

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
  return shapes_ <= kMaxShapes && triangles_ + triangles_of(so_far) <= most_triangles_;
}

std::string MeshStore::why_full() const {
  return shapes_ > kMaxShapes ? "there are more than " + std::to_string(kMaxShapes) + " shapes"
                              : "the scene has more than " + std::to_string(most_triangles_) + " triangles";
}

std::optional<size_t> MeshStore::add(Mesh mesh) {
  if (mesh.surfaces.empty()) return std::nullopt;
  const uint64_t hash = hash_of(mesh);
  const auto [first, last] = by_hash_.equal_range(hash);
  for (auto known = first; known != last; ++known)
    if (model_.meshes[known->second].surfaces == mesh.surfaces) return known->second;
  triangles_ += triangles_of(mesh);
  for (Surface& surface : mesh.surfaces) {
    surface.positions.shrink_to_fit();
    surface.normals.shrink_to_fit();
    surface.uvs.shrink_to_fit();
    surface.indices.shrink_to_fit();
  }
  by_hash_.emplace(hash, model_.meshes.size());
  model_.meshes.push_back(std::move(mesh));
  return model_.meshes.size() - 1;
}

}  // namespace fire3dv::convert
