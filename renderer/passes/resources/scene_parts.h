// Lists that the GPU scene is made of: sorted draws, primitive instances with their clusters, and the
// geometry of acceleration structures.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/scene.h"
#include "shaders/shared/geometry_types.h"

namespace fire3dv::gpu {
struct TriangleGeometry;
}

namespace fire3dv::passes {

struct GpuScene;
struct SceneUses;

struct Draw {
  uint32_t node = 0;
  uint32_t primitive = 0;
};

// Draws with equal pipeline state.
struct DrawBin {
  scene::Topology topology = scene::Topology::triangles;
  scene::AlphaMode alpha_mode = scene::AlphaMode::opaque;
  bool double_sided = false;
  bool mirrored = false;  // negative determinant: flips the winding
  uint32_t first_draw = 0;
  uint32_t draw_count = 0;

  bool blended() const { return alpha_mode == scene::AlphaMode::blend; }
  // Forward-only: the compute rasteriser cannot draw it.
  bool is_forward_only() const { return blended() || topology != scene::Topology::triangles; }
};

// Draws of a scene, sorted by pipeline state, material and primitive to minimise state changes. It has no
// Vulkan dependency, so that tests need no GPU.
struct DrawList {
  std::vector<Draw> draws;
  std::vector<DrawBin> bins;  // opaque, then mask, then blend; in each: triangles, lines, points

  // mirrored: per node, true for a negative determinant. hidden: per node, or empty if none is hidden.
  // refracts: see drawn_alpha_mode().
  static DrawList collect(const scene::Scene& scene, const std::vector<bool>& mirrored,
                          const std::vector<bool>& hidden = {}, bool refracts = false);
};

bool any_blended(const DrawList& list);

// A planar primitive instance.
struct PlanarCaster {
  uint32_t part;
  uint32_t node;
  glm::vec4 plane_node;
  float radius_m;  // of its mesh, in the rest pose
};

// Primitive instances (a primitive at a node) and their clusters, in scene order. Ids and draws refer to
// them.
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

// Alpha mode that a surface is drawn with. Transmissive surfaces are blended, unless their light is refracted
// by rays (GpuScene::refracts).
scene::AlphaMode drawn_alpha_mode(const scene::Material& material, bool refracts);
bool any_transmissive(const scene::Scene& scene);

// True if the scene has forward-only draws.
bool any_forward_only(const scene::Scene& scene, bool refracts);
bool any_masked(const scene::Scene& scene);
bool any_blended_triangles(const scene::Scene& scene);  // or transmissive ones

std::vector<gpu_types::ClusterRecord> cluster_records(const scene::ClusteredGeometry& geometry);
std::vector<gpu_types::LevelGroupRecord> level_group_records(const scene::ClusteredGeometry& geometry);

bool casts_shadow(const scene::Scene& scene, uint32_t primitive);

// Bounding sphere of a mesh's primitives: centre and radius, node space.
glm::vec4 sphere_around(const scene::Scene& scene, const scene::Mesh& mesh);

// Node of a draw's transform. Skinned vertices are in world space, so they use one of two static nodes behind
// the scene's own. One is the identity; the other mirrors, for meshes that their joints mirror, to preserve
// the winding.
uint32_t transform_index_of(const scene::Scene& scene, uint32_t node);

// Need for index buffers: false where all draws use clusters, no mesh is deformed and rays are traced to
// boxes only.
bool needs_indices(const scene::Scene& scene, const scene::ClusteredGeometry& clustered,
                   const SceneUses& uses, bool traces_rays);

// Geometry of the bottom-level acceleration structures, as triangles or boxes. Geometries of each mesh, from
// its positions, indices and boxes; empty for a mesh that only deformed nodes use.
std::vector<std::vector<gpu::TriangleGeometry>> static_geometry(const scene::Scene& scene,
                                                                const GpuScene& gpu_scene);
// Geometries of each deformed node in a world.
std::vector<std::vector<gpu::TriangleGeometry>> deformed_geometry(const scene::Scene& scene,
                                                                  const GpuScene& gpu_scene, uint32_t world);

}  // namespace fire3dv::passes
