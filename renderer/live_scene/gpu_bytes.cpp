#include "renderer/live_scene/gpu_bytes.h"

#include <algorithm>
#include <set>
#include <utility>

#include "renderer/scene/clusters/clusters.h"
#include "shaders/shared/types.h"

namespace fire3dv::app {
namespace {

// Vulkan gives exact sizes of acceleration structures only for a device
// (vkGetAccelerationStructureBuildSizesKHR). lavapipe (Mesa 22.3 to 24) reports up to 200 bytes a triangle,
// the scratch memory of the build included.
constexpr uint64_t kStructureBytesPerTriangle = 200;
// An instance: VkAccelerationStructureInstanceKHR and its share of the top level.
constexpr uint64_t kInstanceBytes = 64 + 200;
// Records of a node: AffineRows, facts, and indices of its first primitive, instance and light.
constexpr uint64_t kNodeBytes = sizeof(gpu_types::AffineRows) + 5 * sizeof(uint32_t);

// Full mip chain of RGBA8: each level has a quarter of the previous one's texels, 4/3 in all.
uint64_t texture_bytes(const scene::Scene& scene) {
  std::set<std::pair<uint32_t, bool>> uploaded;
  uint64_t bytes = 0;
  for (const scene::Texture& texture : scene.textures) {
    if (!uploaded.emplace(texture.image, texture.srgb).second) continue;
    const scene::Image& image = scene.images[texture.image];
    bytes += uint64_t{image.width} * image.height * 4 * 4 / 3;
  }
  return bytes;
}

uint64_t vertex_bytes(const scene::Scene& scene, bool deformed) {
  uint64_t bytes = sizeof(glm::vec3) + sizeof(scene::TangentFrame);
  if (!scene.uvs.empty()) bytes += sizeof(scene.uvs[0]);
  if (!scene.tangents.empty() || deformed) bytes += sizeof(scene::TangentXy);
  if (!scene.extras.empty()) bytes += sizeof(scene::VertexExtras);
  return bytes;
}

struct MeshBytes {
  uint64_t shape = 0;      // once more for each deformed node
  uint64_t structure = 0;  // acceleration structure
  uint64_t instance = 0;   // once for each node
};

MeshBytes mesh_bytes(const scene::Scene& scene, const scene::Derived& derived, const scene::Mesh& mesh,
                     bool deformed) {
  MeshBytes bytes;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const scene::ClusteredPrimitive& geometry = derived.clusters.primitives[p];
    const uint64_t clusters = uint64_t{geometry.cluster_count} + geometry.level_cluster_count;
    bytes.shape += geometry.vertex_count * vertex_bytes(scene, deformed) +
                   geometry.index_count * sizeof(uint32_t) + clusters * sizeof(gpu_types::ClusterRecord) +
                   sizeof(gpu_types::PrimitiveRecord);
    bytes.instance += clusters * (sizeof(gpu_types::ClusterInstance) + sizeof(uint32_t)) +
                      sizeof(gpu_types::PartRecord) + sizeof(gpu_types::DrawRecord);
    if (scene.primitives[p].topology == scene::Topology::triangles)
      bytes.structure += geometry.index_count / 3 * kStructureBytesPerTriangle;
  }
  return bytes;
}

}  // namespace

uint64_t estimate_deformed_bytes(const scene::Scene& scene, const scene::Derived& derived, uint32_t node) {
  const MeshBytes bytes = mesh_bytes(scene, derived, scene.meshes[scene.nodes[node].mesh], true);
  return bytes.shape + bytes.structure;
}

uint64_t estimate_gpu_bytes(const scene::Scene& scene, const scene::Derived& derived) {
  const scene::ClusteredGeometry& clustered = derived.clusters;
  const bool deformed = std::any_of(scene.nodes.begin(), scene.nodes.end(), scene::is_deformed);
  uint64_t bytes = texture_bytes(scene) + scene.materials.size() * sizeof(gpu_types::MaterialRecord) * 2 +
                   scene.lights.size() * sizeof(gpu_types::LightRecord) + scene.nodes.size() * kNodeBytes;
  // Includes vertices of coarser LODs.
  bytes += clustered.source_vertices.size() * vertex_bytes(scene, deformed) +
           clustered.triangles.size() * sizeof(uint32_t) +
           clustered.clusters.size() * sizeof(gpu_types::ClusterRecord) +
           clustered.level_groups.size() * sizeof(gpu_types::LevelGroupRecord) +
           clustered.ray_boxes.size() * sizeof(gpu_types::RayBoxRecord) +
           clustered.primitives.size() * sizeof(gpu_types::PrimitiveRecord);
  bytes += scene.influences.size() * sizeof(scene::Influences) +
           scene.morph_deltas.size() * sizeof(scene::MorphDelta);
  std::vector<MeshBytes> meshes;
  for (const scene::Mesh& mesh : scene.meshes) {
    meshes.push_back(mesh_bytes(scene, derived, mesh, deformed));
    bytes += meshes.back().structure;
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p)
      bytes += clustered.primitives[p].index_count * sizeof(uint32_t);
  }
  for (const scene::Node& node : scene.nodes) {
    if (node.mesh == scene::kNone) continue;
    const MeshBytes& mesh = meshes[node.mesh];
    bytes += mesh.instance + kInstanceBytes;
    if (scene::is_deformed(node)) bytes += mesh.shape + mesh.structure;
  }
  return bytes;
}

}  // namespace fire3dv::app
