// The GPU's copy of a Scene: derived, never edited. Geometry, materials and textures are uploaded once; what
// moves is written by the transforms pass.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/gpu/acceleration.h"
#include "renderer/gpu/bindless_textures.h"
#include "renderer/gpu/resources.h"
#include "renderer/gpu/upload_belt.h"
#include "renderer/passes/deformed_shapes.h"
#include "renderer/passes/draw_list.h"
#include "renderer/passes/scene_parts.h"
#include "renderer/passes/scene_textures.h"
#include "renderer/scene/derived.h"
#include "renderer/scene/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

// A node whose vertices are replaced while it is shown.
struct OwnVertices {
  uint32_t node = 0;
  uint32_t first_vertex = 0;          // of GpuScene::positions
  std::vector<uint32_t> vertices;     // of the scene, in the order of the GPU's
  std::vector<uint32_t> mesh_places;  // of the same, counted from the mesh's first one
};

// How a scene is drawn, as far as it says what is kept of it.
struct SceneUses {
  float anisotropy = 1;  // most texels that a smooth texture's sample spans along its longer side; 1 = none
  gpu::Rays rays = gpu::Rays::many;
  bool rays_to_boxes = false;  // as gpu::traces_to_boxes() has it, but not for a ray-tracing pipeline
  bool drawn_forward = true;   // all of it, not only what the visibility buffer cannot hold
};

struct GpuScene {
  // textures_layout: see gpu::BindlessTextures.
  GpuScene(gpu::Device& device, const scene::Scene& scene, const scene::Derived& derived,
           VkDescriptorSetLayout textures_layout, const gpu::EnvironmentTextures& environment,
           const SceneUses& uses);

  // Sorts the draws anew when poses or bindings have turned a node inside out, or back.
  void follow_senses(gpu::Recorder& recorder, gpu::UploadBelt& belt, const scene::Scene& scene,
                     const state::PoseState& poses);
  // What is drawn now: not what is hidden, and each with the primitives that it has now.
  void collect_draws(gpu::Recorder& recorder, gpu::UploadBelt& belt, const scene::Scene& scene);

  // What shaders read of a scene that this frame may have written.
  void add_reads(std::vector<gpu::Use>& uses, const gpu::Access& access);
  // Of the scene's primitive at a node: its own where the node is deformed.
  uint32_t primitive_at(uint32_t node, uint32_t primitive) const {
    return primitive + primitive_shift_of_node[node];
  }
  const scene::ClusteredPrimitive& geometry_of(const Draw& draw) const {
    return geometry[primitive_at(draw.node, draw.primitive)];
  }
  bool is_hidden(uint32_t node) const { return node < hidden.size() && hidden[node]; }

  uint32_t node_count = 0;
  uint32_t light_count = 0, part_count = 0, ray_box_count = 0;
  uint32_t instance_count = 0;              // of the top-level acceleration structure
  uint32_t cluster_instance_count = 0;      // of all levels of detail
  uint32_t own_cluster_instance_count = 0;  // of the file's own, which come first
  uint64_t own_triangle_count = 0;          // of these
  bool has_on_top = false;                  // something that only the forward pass draws
  bool has_masked = false;
  bool has_extensions = false;  // materials with more than glTF's core
  bool has_textures = false;    // materials with any
  bool has_second_uv = false;   // that a texture takes

  // Of vertices, in cluster order; tangents and extras: null where no vertex has any, nor can come
  // to one.
  gpu::Buffer positions, frames, tangents, uvs, extras;
  gpu::Buffer indices;    // of corners, as scene::ClusterIndices; none where nobody reads them
  gpu::Buffer ray_boxes;  // scene::RayBox[], where rays are traced to boxes
  gpu::Buffer parts, clusters, cluster_triangles, cluster_instances, level_groups;
  std::vector<scene::ClusteredPrimitive> geometry;  // of each primitive of the scene, then of deformed nodes
  std::vector<uint32_t>
      primitive_shift_of_node;  // from the scene's primitives to those of the node; most are 0
  DeformedShapes deformed;
  gpu::Buffer materials, material_extensions, primitives, lights;
  gpu::Buffer draws;                    // DrawRecord[], in the order of the draw list
  gpu::Buffer first_primitive_of_node;  // uint[]
  gpu::Buffer instance_of_node;         // uint[]
  gpu::Buffer instances;                // VkAccelerationStructureInstanceKHR[]
  gpu::Buffer light_of_node;            // uint[]
  // Written by the transforms pass: AffineRows[], with the frames of skinned parts behind; and what follows
  // from them, in the same buffer.
  gpu::Buffer world_from_node;
  VkDeviceSize node_facts_offset = 0;    // uint[]: FIRE3DV_NODE_*
  VkDeviceSize light_places_offset = 0;  // LightPlace[], last
  VkDeviceAddress node_facts() const { return world_from_node.address + node_facts_offset; }
  VkDeviceAddress light_places() const { return world_from_node.address + light_places_offset; }

  void place_nodes(gpu::Device& device, gpu::LoaderCommands& loader);

  // What edits of the scene refer to, see edit_follower.h.
  std::vector<OwnVertices> own_vertices;
  uint32_t own_primitive_count = 0, own_material_count = 0;  // behind them are copies with other colours
  std::vector<uint32_t> part_flags;                          // as the scene has them
  std::vector<uint32_t> light_at_node;                       // as light_of_node
  std::vector<uint32_t> instance_at_node;  // of the top-level structure; FIRE3DV_NO_INDEX = none
  std::vector<bool> hidden;                // of each node, as the draw list has it; empty: none

  std::vector<uint32_t> first_part_of_node;
  std::vector<PlanarPart> planar_parts;  // the largest at rest first
  std::vector<bool> mirrored;            // of each node, as the draw list has it
  DrawList draw_list;
  uint64_t draw_list_revision = 0;  // +1 whenever the list changes
  uint64_t poses_seen = UINT64_MAX;
  SceneTextures scene_textures;
  std::vector<gpu::AccelerationStructure> blas_of_mesh;
  gpu::TopLevel top_level;  // where rays can be traced
  gpu::BindlessTextures textures;
  gpu::BlasBuildReport blas_report;
};

// i: of the mesh's.
gpu_types::PrimitiveRecord primitive_record(const scene::Scene& scene, const scene::Mesh& mesh,
                                            const scene::ClusteredPrimitive& geometry, uint32_t i);

}  // namespace fire3dv::passes
