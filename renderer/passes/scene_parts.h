// Every primitive at every node, and the clusters of each, in the order of the scene: what ids and draws
// refer to.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/caster_shape.h"
#include "renderer/scene/clusters.h"
#include "renderer/scene/scene.h"
#include "shaders/shared/geometry_types.h"

namespace fire3dv::passes {

struct GpuScene;

// A part that lies in one plane.
struct PlanarPart {
  uint32_t part;
  uint32_t node;
  glm::vec4 plane_node;
  float radius_m;  // of its mesh, at rest
};

struct Parts {
  std::vector<gpu_types::PartRecord> parts;
  std::vector<gpu_types::ClusterInstance> clusters;
  uint32_t own_cluster_count = 0;  // the first ones; the others are coarser levels of detail
  std::vector<PlanarPart> planar;  // the largest first
  std::vector<uint32_t> first_of_node;
};

// casters: of each mesh. gpu_scene: what it knows of primitives at nodes; their `clusters`.
Parts collect_parts(const scene::Scene& scene, const std::vector<scene::Caster>& casters,
                    std::span<const scene::Cluster> clusters, const GpuScene& gpu_scene);

// Whether anything of it is drawn by the forward pass alone, on top of the rest.
bool any_on_top(const scene::Scene& scene);
bool any_masked(const scene::Scene& scene);

std::vector<gpu_types::ClusterRecord> cluster_records(const scene::ClusteredGeometry& geometry);
std::vector<gpu_types::LevelGroupRecord> level_group_records(const scene::ClusteredGeometry& geometry);

bool casts_shadow(const scene::Scene& scene, uint32_t primitive);

// Around all primitives of a mesh: middle and radius, in its node's frame.
glm::vec4 sphere_around(const scene::Scene& scene, const scene::Mesh& mesh);

// Skinned vertices are in the world already: they are drawn at nodes that never move, behind the scene's own.
// One is the world; the other one mirrors it, for figures that their joints mirror, so that front faces stay
// front faces.
uint32_t drawn_at(const scene::Scene& scene, uint32_t node);

}  // namespace fire3dv::passes
