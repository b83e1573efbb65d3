#include "renderer/scene/edits/derived.h"

#include "renderer/scene/clusters/cluster_levels.h"

namespace fire3dv::scene {

bool needs_levels(const Scene& scene, Levels levels) {
  if (levels != Levels::automatic_levels) return levels == Levels::all;
  constexpr uint64_t kFewestDrawn = 20'000'000, kMaxInFile = 1'000'000;
  const auto triangles_of = [&](const Mesh& mesh) {
    uint64_t triangles = 0;
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      if (scene.primitives[p].topology == Topology::triangles)
        triangles += scene.primitives[p].index_count / 3;
    }
    return triangles;
  };
  uint64_t drawn = 0, in_file = 0;
  std::vector<uint64_t> of_mesh;
  for (const Mesh& mesh : scene.meshes) in_file += of_mesh.emplace_back(triangles_of(mesh));
  for (const Node& node : scene.nodes) drawn += node.mesh == kNone ? 0 : of_mesh[node.mesh];
  return drawn >= kFewestDrawn && in_file <= kMaxInFile;
}

Derived derive(const Scene& scene, Levels levels, const LoadProgress& progress) {
  const bool with_levels = needs_levels(scene, levels);
  Derived derived;
  derived.clusters = cut_clusters(scene, [&](size_t done) {
    if (progress) progress("clusters", done, scene.primitives.size());
  });
  derived.casters = classify_casters(scene);
  if (with_levels) {
    add_cluster_levels(scene, derived.clusters, [&](size_t done, size_t total) {
      if (progress) progress("levels of detail", done, total);
    });
  }
  derived.has_levels = with_levels;
  return derived;
}

}  // namespace fire3dv::scene
