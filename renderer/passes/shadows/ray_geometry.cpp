#include "renderer/passes/shadows/ray_geometry.h"

#include <algorithm>
#include <span>

namespace fire3dv::passes {
namespace {

// first_primitive: first of the primitives that represent the mesh.
std::vector<gpu::TriangleGeometry> shadow_geometry(const scene::Scene& scene, const GpuScene& gpu_scene,
                                                   const scene::Mesh& mesh, uint32_t first_primitive) {
  std::vector<gpu::TriangleGeometry> geometries;
  for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
    const uint32_t p = mesh.first_primitive + i;
    const scene::ClusteredPrimitive& primitive = gpu_scene.geometry[first_primitive + i];
    const scene::AlphaMode alpha_mode =
        scene::drawn_alpha_mode(scene.materials[scene.primitives[p].material]);
    gpu::TriangleGeometry geometry;
    geometry.positions = gpu_scene.positions.address + uint64_t{primitive.first_vertex} * sizeof(glm::vec3);
    geometry.indices = gpu_scene.indices.address + uint64_t{primitive.first_index} * sizeof(uint32_t);
    geometry.vertex_count = primitive.vertex_count;
    // Blended and transmissive surfaces cast no shadow. An empty geometry preserves the indices of the
    // others.
    geometry.triangle_count = casts_shadow(scene, p) ? primitive.index_count / 3 : 0;
    geometry.opaque = alpha_mode == scene::AlphaMode::opaque;
    geometries.push_back(geometry);
  }
  return geometries;
}

// True if all shadow-casting primitives of a mesh are opaque and have boxes.
bool has_boxes_for_all(const scene::Scene& scene, std::span<const scene::ClusteredPrimitive> geometry,
                       const scene::Mesh& mesh) {
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    if (!casts_shadow(scene, p) || geometry[p].index_count == 0) continue;
    const scene::Material& material = scene.materials[scene.primitives[p].material];
    if (scene::drawn_alpha_mode(material) != scene::AlphaMode::opaque || geometry[p].ray_box_count == 0)
      return false;
  }
  return true;
}

// The same as boxes, where rays are traced to boxes. Deformed meshes keep their triangles.
std::vector<gpu::TriangleGeometry> still_geometry(const scene::Scene& scene, const GpuScene& gpu_scene,
                                                  const scene::Mesh& mesh) {
  std::vector<gpu::TriangleGeometry> geometries =
      shadow_geometry(scene, gpu_scene, mesh, mesh.first_primitive);
  if (!gpu_scene.ray_boxes || !has_boxes_for_all(scene, gpu_scene.geometry, mesh)) return geometries;
  for (size_t i = 0; i < geometries.size(); ++i) {
    const scene::ClusteredPrimitive& primitive = gpu_scene.geometry[mesh.first_primitive + i];
    geometries[i].boxes = gpu_scene.ray_boxes.address;
    if (geometries[i].triangle_count == 0) continue;
    geometries[i].boxes += uint64_t{primitive.first_ray_box} * gpu::kBoxStride;
    geometries[i].box_count = primitive.ray_box_count;
  }
  return geometries;
}

}  // namespace

bool needs_indices(const scene::Scene& scene, const scene::ClusteredGeometry& clustered,
                   const SceneUses& uses, bool traces_rays) {
  if (uses.drawn_forward || any_forward_only(scene)) return true;
  if (std::any_of(scene.nodes.begin(), scene.nodes.end(), scene::is_deformed)) return true;
  if (!traces_rays) return false;
  return !uses.rays_to_boxes || clustered.ray_boxes.empty() ||
         !std::all_of(scene.meshes.begin(), scene.meshes.end(), [&](const scene::Mesh& mesh) {
           return has_boxes_for_all(scene, clustered.primitives, mesh);
         });
}

std::vector<std::vector<gpu::TriangleGeometry>> static_geometry(const scene::Scene& scene,
                                                                const GpuScene& gpu_scene) {
  std::vector<std::vector<gpu::TriangleGeometry>> meshes(scene.meshes.size());
  for (const scene::Node& node : scene.nodes) {
    if (node.mesh == scene::kNone || scene::is_deformed(node) || !meshes[node.mesh].empty()) continue;
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    meshes[node.mesh] = still_geometry(scene, gpu_scene, mesh);
  }
  return meshes;
}

std::vector<std::vector<gpu::TriangleGeometry>> deformed_geometry(const scene::Scene& scene,
                                                                  const GpuScene& gpu_scene) {
  std::vector<std::vector<gpu::TriangleGeometry>> meshes;
  for (const scene::DeformedNode& shape : gpu_scene.deformed.nodes) {
    const scene::Mesh& mesh = scene.meshes[scene.nodes[shape.node].mesh];
    meshes.push_back(shadow_geometry(scene, gpu_scene, mesh, shape.first_primitive));
  }
  return meshes;
}

}  // namespace fire3dv::passes
