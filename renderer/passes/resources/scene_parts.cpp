#include "renderer/passes/resources/scene_parts.h"

#include <algorithm>
#include <tuple>

#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::passes {
namespace {

bool is_colored(const scene::Scene& scene, const scene::Primitive& primitive) {
  if (scene.extras.empty()) return false;
  for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + primitive.vertex_count; ++v) {
    if (scene::has_color(scene, v)) return true;
  }
  return false;
}

bool is_on_top(const scene::Scene& scene, const scene::Primitive& primitive, bool refracts) {
  return primitive.topology != scene::Topology::triangles ||
         drawn_alpha_mode(scene.materials[primitive.material], refracts) == scene::AlphaMode::blend;
}

// Maps of closed meshes have no light on the far side of a surface.
bool casts_as_closed(const scene::Caster& caster, const scene::Material& material) {
  return caster.shape == scene::CasterShape::closed && material.diffuse_transmission == 0;
}

uint32_t part_flags(const scene::Scene& scene, uint32_t primitive, const scene::Caster& caster,
                    bool refracts) {
  const scene::Primitive& p = scene.primitives[primitive];
  const scene::Material& material = scene.materials[p.material];
  const scene::AlphaMode alpha_mode = drawn_alpha_mode(material, refracts);
  return (material.double_sided ? FIRE3DV_PART_DOUBLE_SIDED : 0) |
         (alpha_mode == scene::AlphaMode::mask ? FIRE3DV_PART_MASK : 0) | (p.lit ? 0 : FIRE3DV_PART_UNLIT) |
         (is_colored(scene, p) ? FIRE3DV_PART_COLORED : 0) |
         (is_on_top(scene, p, refracts) ? FIRE3DV_PART_FORWARD_ONLY : 0) |
         (casts_shadow(scene, primitive) ? 0 : FIRE3DV_PART_NO_SHADOW) |
         (casts_as_closed(caster, material) ? FIRE3DV_PART_CLOSED : 0) |
         (caster.shape == scene::CasterShape::planar ? FIRE3DV_PART_PLANAR : 0);
}

// An id has 25 bits for the cluster instance, see gpu_types::ClusterInstance.
constexpr uint64_t kMaxClusterInstances = (uint64_t{1} << 25) - 1;

void add_clusters(Parts& all, std::span<const scene::Cluster> clusters, uint32_t part, uint32_t first,
                  uint32_t count) {
  for (uint32_t c = first; c < first + count; ++c) {
    const scene::Cluster& cluster = clusters[c];
    all.clusters.push_back({part, c, all.parts[part].node, cluster.first_vertex, cluster.first_triangle,
                            cluster.vertex_count | cluster.triangle_count << 16});
  }
}

// Adds all coarser clusters or none: a partial LOD hierarchy would leave holes.
void add_coarser_clusters(const GpuScene& gpu_scene, std::span<const scene::Cluster> clusters, Parts& all) {
  uint64_t count = all.clusters.size();
  for (const gpu_types::PartRecord& part : all.parts)
    count += gpu_scene.geometry[part.primitive].level_cluster_count;
  if (count > kMaxClusterInstances) return;
  for (uint32_t part = 0; part < all.parts.size(); ++part) {
    if ((all.parts[part].flags & FIRE3DV_PART_DEFORMED) != 0) continue;
    const scene::ClusteredPrimitive& geometry = gpu_scene.geometry[all.parts[part].primitive];
    add_clusters(all, clusters, part, geometry.first_level_cluster, geometry.level_cluster_count);
  }
}

// Triangles that rays meet: for shadow rays those of shadow casters, for paths and refraction all.
bool meets_rays(const scene::Scene& scene, const GpuScene& gpu_scene, uint32_t primitive) {
  if (!gpu_scene.is_path_traced && !gpu_scene.refracts) return casts_shadow(scene, primitive);
  return scene.primitives[primitive].topology == scene::Topology::triangles;
}

// first_primitive: first of the primitives that represent the mesh.
std::vector<gpu::TriangleGeometry> ray_geometry(const scene::Scene& scene, const GpuScene& gpu_scene,
                                                uint32_t world, const scene::Mesh& mesh,
                                                uint32_t first_primitive) {
  std::vector<gpu::TriangleGeometry> geometries;
  for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
    const uint32_t p = mesh.first_primitive + i;
    const scene::ClusteredPrimitive& primitive = gpu_scene.geometry[first_primitive + i];
    const scene::Material& material = scene.materials[scene.primitives[p].material];
    // Paths pass a transmissive surface by its BRDF, not by its alpha.
    const scene::AlphaMode alpha_mode =
        gpu_scene.is_path_traced ? material.alpha_mode : scene::drawn_alpha_mode(material);
    gpu::TriangleGeometry geometry;
    geometry.positions =
        gpu_scene.vertices_of(world).positions.address + uint64_t{primitive.first_vertex} * sizeof(glm::vec3);
    geometry.indices = gpu_scene.indices.address + uint64_t{primitive.first_index} * sizeof(uint32_t);
    geometry.vertex_count = primitive.vertex_count;
    // An empty geometry preserves the indices of the others.
    geometry.triangle_count = meets_rays(scene, gpu_scene, p) ? primitive.index_count / 3 : 0;
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
      ray_geometry(scene, gpu_scene, 0, mesh, mesh.first_primitive);
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

DrawList DrawList::collect(const scene::Scene& scene, const std::vector<bool>& mirrored,
                           const std::vector<bool>& hidden, bool refracts) {
  struct Candidate {
    Draw draw;
    scene::Topology topology;
    scene::AlphaMode alpha_mode;
    bool double_sided, inside_out;
    uint32_t material;
    auto key() const {
      return std::tuple(alpha_mode, topology, double_sided, inside_out, material, draw.primitive, draw.node);
    }
    bool same_bin(const DrawBin& bin) const {
      return topology == bin.topology && alpha_mode == bin.alpha_mode && double_sided == bin.double_sided &&
             inside_out == bin.mirrored;
    }
  };
  std::vector<Candidate> candidates;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    const scene::Node& node = scene.nodes[n];
    if (node.mesh == scene::kNone || (!hidden.empty() && hidden[n])) continue;
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const uint32_t material = scene.primitives[p].material;
      candidates.push_back({{n, p},
                            scene.primitives[p].topology,
                            drawn_alpha_mode(scene.materials[material], refracts),
                            scene.materials[material].double_sided,
                            mirrored[n],
                            material});
    }
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.key() < b.key(); });

  DrawList list;
  for (const Candidate& c : candidates) {
    if (list.bins.empty() || !c.same_bin(list.bins.back())) {
      list.bins.push_back({c.topology, c.alpha_mode, c.double_sided, c.inside_out,
                           static_cast<uint32_t>(list.draws.size()), 0});
    }
    list.bins.back().draw_count++;
    list.draws.push_back(c.draw);
  }
  return list;
}

bool any_blended(const DrawList& list) {
  return std::any_of(list.bins.begin(), list.bins.end(), [](const DrawBin& bin) { return bin.blended(); });
}

scene::AlphaMode drawn_alpha_mode(const scene::Material& material, bool refracts) {
  return refracts ? material.alpha_mode : scene::drawn_alpha_mode(material);
}

bool casts_shadow(const scene::Scene& scene, uint32_t primitive) {
  return !is_on_top(scene, scene.primitives[primitive], false);
}

bool any_transmissive(const scene::Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const scene::Material& material) {
    return material.transmission > 0 && !material.unlit;
  });
}

bool any_forward_only(const scene::Scene& scene, bool refracts) {
  return std::any_of(
      scene.primitives.begin(), scene.primitives.end(),
      [&](const scene::Primitive& primitive) { return is_on_top(scene, primitive, refracts); });
}

bool any_masked(const scene::Scene& scene) {
  return std::any_of(
      scene.primitives.begin(), scene.primitives.end(), [&](const scene::Primitive& primitive) {
        return scene::drawn_alpha_mode(scene.materials[primitive.material]) == scene::AlphaMode::mask;
      });
}

bool any_blended_triangles(const scene::Scene& scene) {
  return std::any_of(
      scene.primitives.begin(), scene.primitives.end(), [&](const scene::Primitive& primitive) {
        return primitive.topology == scene::Topology::triangles &&
               scene::drawn_alpha_mode(scene.materials[primitive.material]) == scene::AlphaMode::blend;
      });
}

std::vector<gpu_types::ClusterRecord> cluster_records(const scene::ClusteredGeometry& geometry) {
  std::vector<gpu_types::ClusterRecord> records;
  records.reserve(geometry.clusters.size());
  for (const scene::Cluster& c : geometry.clusters) {
    records.push_back({c.center, c.radius, c.cone_axis, c.cone_cutoff, c.first_vertex, c.first_triangle,
                       c.vertex_count, c.triangle_count, c.made_by, c.merged_by,
                       c.made_by == scene::kNone ? 0 : geometry.level_groups[c.made_by].surface_error, 0});
  }
  return records;
}

std::vector<gpu_types::LevelGroupRecord> level_group_records(const scene::ClusteredGeometry& geometry) {
  std::vector<gpu_types::LevelGroupRecord> records;
  records.reserve(geometry.level_groups.size());
  for (const scene::LevelGroup& g : geometry.level_groups)
    records.push_back({g.center, g.radius, g.error, g.surface_error});
  return records;
}

glm::vec4 sphere_around(const scene::Scene& scene, const scene::Mesh& mesh) {
  glm::vec3 low(0), high(0);
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const scene::Primitive& primitive = scene.primitives[p];
    low = p == mesh.first_primitive ? primitive.bounds_min : glm::min(low, primitive.bounds_min);
    high = p == mesh.first_primitive ? primitive.bounds_max : glm::max(high, primitive.bounds_max);
  }
  return {0.5f * (low + high), 0.5001f * glm::length(high - low)};
}

uint32_t transform_index_of(const scene::Scene& scene, uint32_t node) {
  if (scene.nodes[node].skin == scene::kNone) return node;
  return static_cast<uint32_t>(scene.nodes.size()) +
         (scene::is_mirrored_by_joints(scene, scene.nodes[node]) ? 1 : 0);
}

Parts collect_parts(const scene::Scene& scene, const std::vector<scene::Caster>& casters,
                    std::span<const scene::Cluster> clusters, const GpuScene& gpu_scene) {
  Parts all;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    const uint32_t mesh = scene.nodes[n].mesh;
    all.first_of_node.push_back(static_cast<uint32_t>(all.parts.size()));
    if (mesh == scene::kNone) continue;
    const uint32_t first = scene.meshes[mesh].first_primitive;
    for (uint32_t p = first; p < first + scene.meshes[mesh].primitive_count; ++p) {
      const auto part = static_cast<uint32_t>(all.parts.size());
      const uint32_t primitive = gpu_scene.primitive_at(n, p);
      const bool deformed = scene::is_deformed(scene.nodes[n]);
      const scene::Caster caster = deformed ? scene::Caster{} : casters[mesh];
      all.parts.push_back(
          {transform_index_of(scene, n), primitive,
           part_flags(scene, p, caster, gpu_scene.refracts) | (deformed ? FIRE3DV_PART_DEFORMED : 0),
           scene.primitives[p].material});
      if (caster.shape == scene::CasterShape::planar) {
        const glm::mat3 m(scene.nodes[n].world_from_node);
        const float stretch = std::max({glm::length(m[0]), glm::length(m[1]), glm::length(m[2])});
        all.planar.push_back(
            {part, n, caster.plane_node, stretch * sphere_around(scene, scene.meshes[mesh]).w});
      }
      const scene::ClusteredPrimitive& geometry = gpu_scene.geometry[primitive];
      add_clusters(all, clusters, part, geometry.first_cluster, geometry.cluster_count);
    }
  }
  // Coarser clusters follow LOD 0, whose indices therefore do not depend on the LOD setting.
  all.lod0_cluster_count = static_cast<uint32_t>(all.clusters.size());
  add_coarser_clusters(gpu_scene, clusters, all);
  std::stable_sort(all.planar.begin(), all.planar.end(),
                   [](const auto& a, const auto& b) { return a.radius_m > b.radius_m; });
  return all;
}

bool needs_indices(const scene::Scene& scene, const scene::ClusteredGeometry& clustered,
                   const SceneUses& uses, bool traces_rays) {
  if (uses.drawn_forward || any_forward_only(scene, uses.refracts)) return true;
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
                                                                  const GpuScene& gpu_scene, uint32_t world) {
  std::vector<std::vector<gpu::TriangleGeometry>> meshes;
  for (const scene::DeformedNode& shape : gpu_scene.deformed.nodes) {
    const scene::Mesh& mesh = scene.meshes[scene.nodes[shape.node].mesh];
    meshes.push_back(ray_geometry(scene, gpu_scene, world, mesh, shape.first_primitive));
  }
  return meshes;
}

}  // namespace fire3dv::passes
