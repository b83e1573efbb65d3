// Primitive instances (a primitive at a node) and their clusters, in scene order. Ids and draws refer to
// them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/shadow_caster.h"
#include "shaders/shared/geometry_types.h"

namespace fire3dv::passes {

struct GpuScene;

// A planar primitive instance.
struct PlanarCaster {
  uint32_t part;
  uint32_t node;
  glm::vec4 plane_node;
  float radius_m;  // of its mesh, in the rest pose
};

struct Parts {
  std::vector<gpu_types::PartRecord> parts;
  std::vector<gpu_types::ClusterInstance> clusters;
  uint32_t lod0_cluster_count = 0;   // LOD 0 clusters, which come first; the others are coarser LODs
  std::vector<PlanarCaster> planar;  // largest first
  std::vector<uint32_t> first_of_node;
};

// casters: per mesh. clusters: of gpu_scene's geometry.
Parts collect_parts(const scene::Scene& scene, const std::vector<scene::Caster>& casters,
                    std::span<const scene::Cluster> clusters, const GpuScene& gpu_scene);

// True if the scene has forward-only draws.
bool any_forward_only(const scene::Scene& scene);
bool any_masked(const scene::Scene& scene);

std::vector<gpu_types::ClusterRecord> cluster_records(const scene::ClusteredGeometry& geometry);
std::vector<gpu_types::LevelGroupRecord> level_group_records(const scene::ClusteredGeometry& geometry);

bool casts_shadow(const scene::Scene& scene, uint32_t primitive);

// Bounding sphere of a mesh's primitives: centre and radius, node space.
glm::vec4 sphere_around(const scene::Scene& scene, const scene::Mesh& mesh);

// Node of a draw's transform. Skinned vertices are in world space, so they use one of two static nodes behind
// the scene's own. One is the identity; the other mirrors, for meshes that their joints mirror, to preserve
// the winding.
uint32_t transform_index_of(const scene::Scene& scene, uint32_t node);

}  // namespace fire3dv::passes
