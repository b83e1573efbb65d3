// GPU copy of a Scene: the geometry that its worlds share, and the state of the worlds. Geometry, materials
// and textures are uploaded once; the transforms pass writes all moving data.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "renderer/gpu/acceleration.h"
#include "renderer/gpu/device/resources.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/passes/resources/pose_passes.h"
#include "renderer/passes/resources/scene_materials.h"
#include "renderer/passes/resources/scene_parts.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/scene.h"
#include "renderer/scene/textures/environment_sun.h"
#include "renderer/state/pose_state.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Per-instance vertices of a node whose vertices an edit replaces.
struct InstanceVertices {
  uint32_t node = 0;
  uint32_t first_vertex = 0;            // in VertexBuffers
  std::vector<uint32_t> vertices;       // scene indices, in the GPU's order
  std::vector<uint32_t> mesh_vertices;  // the same, relative to the mesh's first vertex
};

// Draw settings that decide which resources the GPU scene needs.
struct SceneUses {
  uint32_t worlds = 1;
  float anisotropy = 1;  // maximum anisotropy of smooth samplers, in texels; 1: none
  gpu::Rays rays = gpu::Rays::many;
  bool rays_to_boxes = false;  // gpu::traces_to_boxes(), and no ray-tracing pipeline
  bool path_traced = false;    // rays meet blended and transmissive surfaces, too
  bool refracts = false;       // so do ray effects; transmissive surfaces are in the visibility buffer
  bool drawn_forward = true;   // whole scene on the forward path, not only its forward-only draws
  std::optional<scene::EnvironmentSun> sun;
  uint32_t lamps = 0;  // beside the lens
};

// Vertices, and the primitives whose spheres enclose them.
struct VertexBuffers {
  // In cluster order. tangents is null where no vertex has any or can get any.
  gpu::Buffer positions, frames, tangents;
  gpu::Buffer primitives;
};

// What all worlds of a scene share: uploaded once, then only edits change it.
struct SceneGeometry {
  uint32_t node_count = 0, mesh_node_count = 0;  // all nodes, and those with a mesh
  uint32_t light_count = 0;                      // with lamps and sun
  uint32_t lamp_count = 0;                       // beside the lens
  uint32_t part_count = 0, ray_box_count = 0;
  uint32_t instance_count = 0;               // of a world's top-level acceleration structure
  uint32_t cluster_instance_count = 0;       // all LODs
  uint32_t lod0_cluster_instance_count = 0;  // LOD 0 only; these come first
  uint64_t lod0_triangle_count = 0;          // LOD 0 triangles
  bool has_forward_only = false;             // has forward-only draws
  bool has_blended_triangles = false;        // blended or transmissive ones, hidden or not
  bool has_masked = false;
  bool has_extensions = false;           // materials with glTF extensions
  bool has_textures = false;             // materials with textures
  bool has_second_uv = false;            // a texture uses the second set
  bool filters_anisotropically = false;  // smooth samplers
  uint32_t material_flags = 0;           // of FIRE3DV_MATERIAL_OPTIONAL those that a material has
  bool is_path_traced = false;           // as in SceneUses
  std::optional<scene::EnvironmentSun> sun;
  bool refracts = false;  // as in SceneUses, in a scene with transmissive surfaces

  gpu::Buffer uvs, extras;  // in cluster order; extras is null where no vertex has any
  gpu::Buffer indices;      // as in scene::ClusterIndices; null where no pass reads them
  gpu::Buffer ray_boxes;    // scene::RayAabb[], where rays are traced to boxes
  gpu::Buffer parts, clusters, cluster_triangles, cluster_instances, level_groups;
  std::vector<scene::ClusteredPrimitive> geometry;  // per primitive of the scene, then of deformed nodes
  std::vector<uint32_t> primitive_shift_of_node;    // offset from a scene primitive to the node's; mostly 0
  DeformedShapes deformed;
  gpu::Buffer materials, material_extensions, lights;
  gpu::Buffer draws;                    // DrawRecord[], in the order of the draw list
  gpu::Buffer first_primitive_of_node;  // uint[]
  gpu::Buffer instance_of_node;         // uint[]
  gpu::Buffer light_of_node;            // uint[]

  // State that scene edits refer to, see edit_uploader.h.
  std::vector<InstanceVertices> instance_vertices;
  uint32_t scene_primitive_count = 0,
           scene_material_count = 0;       // further records are copies with edited colours
  std::vector<uint32_t> part_flags;        // as in the scene file
  std::vector<uint32_t> light_at_node;     // as in light_of_node
  std::vector<uint32_t> instance_at_node;  // in the top-level structure; FIRE3DV_NO_INDEX: none
  std::vector<bool> hidden;                // per node, as in the draw list; empty: none

  std::vector<uint32_t> first_part_of_node;
  std::vector<PlanarCaster> planar_casters;  // sorted by rest-pose size, largest first
  SceneTextures scene_textures;
  struct Sky {
    uint32_t texture = 0, image_height_px = 1;
  };
  std::optional<Sky> sky;  // see scene::Scene
  std::vector<gpu::AccelerationStructure> blas_of_mesh;
  gpu::BindlessTextures textures;
  gpu::BlasBuildReport blas_report;

  // Primitive of a node: per-instance where the node is deformed.
  uint32_t primitive_at(uint32_t node, uint32_t primitive) const {
    return primitive + primitive_shift_of_node[node];
  }
  const scene::ClusteredPrimitive& geometry_of(const Draw& draw) const {
    return geometry[primitive_at(draw.node, draw.primitive)];
  }
  // Node of each part. Parts of skinned nodes hold a static transform instead.
  std::vector<uint32_t> nodes_of_parts() const;
  bool is_hidden(uint32_t node) const { return node < hidden.size() && hidden[node]; }
};

// What moves in the worlds of a scene: copies of the scene that differ in their poses. One allocation holds
// the data of all worlds, at a stride.
struct WorldState {
  uint32_t world_count = 1;
  // Written by the transforms pass. Of each world: AffineRows[], then the static transforms of skinned parts,
  // then node facts. Then the light poses of each world.
  gpu::Buffer world_from_node;
  VkDeviceSize node_bytes = 0;         // stride of the worlds' nodes
  VkDeviceSize node_facts_offset = 0;  // in a world's nodes; uint[]: FIRE3DV_NODE_*
  VkDeviceSize light_bytes = 0;        // stride of the worlds' LightPose[]
  gpu::Buffer instances;            // VkAccelerationStructureInstanceKHR[world][], where rays can be traced
  VkDeviceSize instance_bytes = 0;  // stride of the worlds' instances
  gpu::TopLevels top_level;
  // By world where vertices are deformed or replaced; otherwise one entry for all.
  std::vector<VertexBuffers> vertices;
  std::vector<DeformedWorld> deformed_worlds;  // by world, where vertices are deformed

  // Draws of one world, sorted by its winding.
  std::vector<bool> mirrored;  // per node, as in the draw list
  DrawList draw_list;
  uint64_t draw_list_revision = 0;  // +1 whenever the list changes
  uint64_t winding_revision = UINT64_MAX;
  uint32_t winding_world = 0;

  VertexBuffers& vertices_of(uint32_t world) { return vertices.size() > 1 ? vertices[world] : vertices[0]; }
  const VertexBuffers& vertices_of(uint32_t world) const {
    return vertices.size() > 1 ? vertices[world] : vertices[0];
  }
  VkDeviceAddress nodes_of(uint32_t world) const { return world_from_node.address + world * node_bytes; }
  VkDeviceAddress node_facts_of(uint32_t world) const { return nodes_of(world) + node_facts_offset; }
  VkDeviceAddress instances_of(uint32_t world) const {
    return instances ? instances.address + world * instance_bytes : 0;
  }
  VkDeviceSize light_poses_offset() const { return world_count * node_bytes; }
  VkDeviceAddress light_poses_of(uint32_t world) const {
    return world_from_node.address + light_poses_offset() + world * light_bytes;
  }
};

// GPU copy of a Scene: derived, never edited, with one or more worlds that share its geometry.
struct GpuScene : SceneGeometry, WorldState {
  // textures_layout: see gpu::BindlessTextures. before: the copy of another scene on the device; images of
  // the same pixels are shared with it.
  GpuScene(gpu::Device& device, const scene::Scene& scene, const scene::Derived& derived,
           VkDescriptorSetLayout textures_layout, const gpu::EnvironmentTextures& environment,
           const SceneUses& uses, const GpuScene* before = nullptr);

  // Sorts the draws again when the world, poses or bindings have changed the winding of a node. poses: of the
  // world.
  void update_winding(gpu::Recorder& recorder, gpu::StagingRing& staging, const scene::Scene& scene,
                      uint32_t world, const state::PoseState& poses);
  // Collects the current draws: visible nodes with their current primitives.
  void collect_draws(gpu::Recorder& recorder, gpu::StagingRing& staging, const scene::Scene& scene);

  // Adds the scene buffers that this frame may have written to a pass's reads.
  void add_reads(std::vector<gpu::Use>& uses, const gpu::Access& access);
  // Addresses of a world's buffers, for its views.
  void write_globals(gpu_types::Globals& globals) const;  // of all worlds
  void write_world_globals(gpu_types::Globals& globals, uint32_t world) const;

 private:
  void create_node_buffer(gpu::Device& device, gpu::LoaderCommands& loader);
};

// i: index within the mesh.
gpu_types::PrimitiveRecord primitive_record(const scene::Scene& scene, const scene::Mesh& mesh,
                                            const scene::ClusteredPrimitive& geometry, uint32_t i);

}  // namespace fire3dv::passes
