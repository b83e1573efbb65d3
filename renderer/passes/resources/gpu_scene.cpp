#include "renderer/passes/resources/gpu_scene.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include "base/parallel.h"
#include "renderer/passes/resources/sun_light.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/model/math.h"
#include "renderer/scene/model/scene_edits.h"

namespace fire3dv::passes {
namespace {

using gpu::Access;

// Uploads the values in another order. All cores write straight to the target: a second host copy would cost
// its page faults.
template <typename T>
gpu::Buffer upload_in_order(gpu::Device& device, gpu::LoaderCommands& loader, const std::vector<T>& values,
                            const std::vector<uint32_t>& source, VkBufferUsageFlags usage) {
  constexpr size_t kChunk = 1 << 14;
  const VkDeviceSize bytes = source.size() * sizeof(T);
  gpu::Buffer buffer = gpu::create_buffer(device, bytes, usage, gpu::filled_memory(device));
  loader.upload(buffer, bytes, sizeof(T), [&](VkDeviceSize offset, std::span<std::byte> to) {
    const size_t first = offset / sizeof(T), count = to.size() / sizeof(T);
    parallel_for((count + kChunk - 1) / kChunk, [&](size_t turn) {
      for (size_t i = turn * kChunk; i < std::min(count, (turn + 1) * kChunk); ++i) {
        std::memcpy(to.data() + i * sizeof(T), &values[source[first + i]], sizeof(T));
      }
    });
  });
  return buffer;
}

gpu::Buffer upload_indices(gpu::Device& device, gpu::LoaderCommands& loader,
                           const scene::ClusterIndices& indices, uint64_t count, VkBufferUsageFlags usage) {
  const VkDeviceSize bytes = count * sizeof(uint32_t);
  gpu::Buffer buffer = gpu::create_buffer(device, bytes, usage, gpu::filled_memory(device));
  loader.upload(buffer, bytes, sizeof(uint32_t), [&](VkDeviceSize offset, std::span<std::byte> to) {
    indices.write(offset / sizeof(uint32_t),
                  {reinterpret_cast<uint32_t*>(to.data()), to.size() / sizeof(uint32_t)});
  });
  return buffer;
}

VkAccelerationStructureInstanceKHR instance_record(uint32_t node, VkDeviceAddress blas) {
  VkAccelerationStructureInstanceKHR instance{};
  instance.instanceCustomIndex = node & 0xffffff;
  instance.mask = 0xff;
  instance.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
  instance.accelerationStructureReference = blas;
  return instance;
}

template <typename Affine>
bool is_mirroring(const Affine& affine) {
  const auto& m = affine.m;
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
             m[2] * (m[4] * m[9] - m[5] * m[8]) <
         0;
}

std::vector<bool> mirrored_at_rest(const scene::Scene& scene) {
  std::vector<bool> mirrored;
  for (const scene::Node& node : scene.nodes) {
    mirrored.push_back(node.skin == scene::kNone ? glm::determinant(glm::mat3(node.world_from_node)) < 0
                                                 : scene::is_mirrored_by_joints(scene, node));
  }
  return mirrored;
}

std::vector<bool> find_mirrored(const scene::Scene& scene, const state::PoseState& poses) {
  std::vector<bool> mirrored;
  mirrored.reserve(poses.node_drives().size());
  for (const state::NodeDrive& drive : poses.node_drives()) {
    bool turned = is_mirroring(drive.body_from_node);
    if (drive.stream != state::kNone) {
      const state::Stream& stream = poses.streams()[drive.stream];
      turned ^= is_mirroring(stream.poses[drive.pose_index]) ^ is_mirroring(stream.world_from_stream);
    }
    const scene::Node& node = scene.nodes[mirrored.size()];
    mirrored.push_back(node.skin == scene::kNone ? turned : scene::is_mirrored_by_joints(scene, node));
  }
  return mirrored;
}

std::vector<gpu_types::PrimitiveRecord> make_primitive_records(const scene::Scene& scene,
                                                               const GpuScene& gpu_scene) {
  std::vector<gpu_types::PrimitiveRecord> records(gpu_scene.geometry.size());
  const auto fill = [&](const scene::Mesh& mesh, uint32_t first_primitive) {
    for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
      records[first_primitive + i] =
          primitive_record(scene, mesh, gpu_scene.geometry[first_primitive + i], i);
    }
  };
  for (const scene::Mesh& mesh : scene.meshes) fill(mesh, mesh.first_primitive);
  for (const scene::DeformedNode& shape : gpu_scene.deformed.nodes) {
    fill(scene.meshes[scene.nodes[shape.node].mesh], shape.first_primitive);
  }
  return records;
}

std::vector<gpu_types::DrawRecord> draw_records(const scene::Scene& scene, const GpuScene& gpu_scene) {
  std::vector<gpu_types::DrawRecord> records;
  uint32_t first_number = 0;  // wraps around
  for (const Draw& draw : gpu_scene.draw_list.draws) {
    const uint32_t first_primitive = scene.meshes[scene.nodes[draw.node].mesh].first_primitive;
    records.push_back(
        {transform_index_of(scene, draw.node), gpu_scene.primitive_at(draw.node, draw.primitive),
         gpu_scene.first_part_of_node[draw.node] + draw.primitive - first_primitive, first_number});
    // Lines and points have fewer indices each: not all numbers are used.
    first_number += gpu_scene.geometry_of(draw).index_count;
  }
  return records;
}

// Static transforms of skinned parts: the identity, and a mirror.
std::vector<gpu_types::AffineRows> first_transforms(uint32_t node_count) {
  std::vector<gpu_types::AffineRows> transforms(node_count);
  transforms.push_back({{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}});
  transforms.push_back({{-1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}});
  return transforms;
}

std::vector<InstanceVertices> find_instance_vertices(const scene::Scene& scene,
                                                     const std::vector<scene::DeformedNode>& nodes,
                                                     const scene::ClusteredGeometry& geometry) {
  std::vector<InstanceVertices> found;
  for (const scene::DeformedNode& shape : nodes) {
    const scene::Node& node = scene.nodes[shape.node];
    if (!node.has_instance_vertices) continue;
    InstanceVertices& own = found.emplace_back();
    own.node = shape.node;
    own.first_vertex = geometry.primitives[shape.first_primitive].first_vertex;  // the copies are contiguous
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    uint32_t first_place = 0;
    for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
      const scene::ClusteredPrimitive& copy = geometry.primitives[shape.first_primitive + i];
      const scene::Primitive& primitive = scene.primitives[mesh.first_primitive + i];
      for (uint32_t v = copy.first_vertex; v < copy.first_vertex + copy.vertex_count; ++v) {
        own.vertices.push_back(geometry.source_vertices[v]);
        own.mesh_vertices.push_back(first_place + geometry.source_vertices[v] - primitive.first_vertex);
      }
      first_place += primitive.vertex_count;
    }
  }
  return found;
}

}  // namespace

gpu_types::PrimitiveRecord primitive_record(const scene::Scene& scene, const scene::Mesh& mesh,
                                            const scene::ClusteredPrimitive& geometry, uint32_t i) {
  const glm::vec4 sphere = sphere_around(scene, mesh);
  return {glm::vec3(sphere),
          sphere.w,
          geometry.first_index,
          geometry.first_vertex,
          scene.primitives[mesh.first_primitive + i].material,
          geometry.first_ray_box};
}

std::vector<uint32_t> SceneGeometry::nodes_of_parts() const {
  std::vector<uint32_t> nodes(part_count);
  for (uint32_t node = 0; node < first_part_of_node.size(); ++node) {
    const uint32_t end = node + 1 < first_part_of_node.size() ? first_part_of_node[node + 1] : part_count;
    std::fill(nodes.begin() + first_part_of_node[node], nodes.begin() + end, node);
  }
  return nodes;
}

void GpuScene::update_winding(gpu::Recorder& recorder, gpu::StagingRing& staging, const scene::Scene& scene,
                              uint32_t world, const state::PoseState& poses) {
  if (winding_revision == poses.revision() && winding_world == world) return;
  winding_revision = poses.revision();
  winding_world = world;
  std::vector<bool> now = find_mirrored(scene, poses);
  if (now == mirrored) return;
  mirrored = std::move(now);
  collect_draws(recorder, staging, scene);
}

void GpuScene::collect_draws(gpu::Recorder& recorder, gpu::StagingRing& staging, const scene::Scene& scene) {
  draw_list = DrawList::collect(scene, mirrored, hidden, refracts);
  ++draw_list_revision;
  const std::vector<gpu_types::DrawRecord> records = draw_records(scene, *this);
  const gpu::StagingRing::Piece piece = staging.write(std::span<const gpu_types::DrawRecord>(records));
  recorder.pass("draws", {gpu::Use(draws, gpu::access::transfer_write)}, [&](VkCommandBuffer commands) {
    const VkBufferCopy copy{piece.offset, 0, records.size() * sizeof(records[0])};
    if (copy.size) vkCmdCopyBuffer(commands, piece.buffer, draws.get(), 1, &copy);
  });
}

void GpuScene::create_node_buffer(gpu::Device& device, gpu::LoaderCommands& loader) {
  const std::vector<gpu_types::AffineRows> transforms = first_transforms(node_count);
  std::vector<uint32_t> facts(node_count, 0);
  facts.push_back(FIRE3DV_NODE_EVEN);
  facts.push_back(FIRE3DV_NODE_EVEN | FIRE3DV_NODE_MIRRORED);
  const auto padded = [](size_t bytes) { return (bytes + 255) / 256 * 256; };
  node_facts_offset = padded(transforms.size() * sizeof(transforms[0]));
  node_bytes = node_facts_offset + padded(facts.size() * sizeof(facts[0]));
  light_bytes = light_count * sizeof(gpu_types::LightPose);
  std::vector<std::byte> bytes(world_count * (node_bytes + light_bytes));
  for (uint32_t world = 0; world < world_count; ++world) {
    std::byte* const nodes = bytes.data() + world * node_bytes;
    std::memcpy(nodes, transforms.data(), transforms.size() * sizeof(transforms[0]));
    std::memcpy(nodes + node_facts_offset, facts.data(), facts.size() * sizeof(facts[0]));
  }
  world_from_node = upload_array(device, loader, bytes);
}

void GpuScene::add_reads(std::vector<gpu::Use>& uses, const gpu::Access& access) {
  uses.emplace_back(world_from_node, access);
  for (VertexBuffers& of_world : vertices) {
    for (gpu::Buffer* written : {&of_world.positions, &of_world.frames, &of_world.primitives})
      uses.emplace_back(*written, access);
    if (of_world.tangents) uses.emplace_back(of_world.tangents, access);
  }
}

void GpuScene::write_world_globals(gpu_types::Globals& globals, uint32_t world) const {
  const VertexBuffers& of_world = vertices_of(world);
  globals.world_from_node = nodes_of(world);
  globals.node_facts = node_facts_of(world);
  globals.light_poses = light_poses_of(world);
  globals.top_level = top_level.empty() ? 0 : top_level.address(world);
  globals.positions = of_world.positions.address;
  globals.frames = of_world.frames.address;
  globals.tangents = of_world.tangents.address;
  globals.primitives = of_world.primitives.address;
}

void GpuScene::write_globals(gpu_types::Globals& globals) const {
  globals.first_primitive_of_node = first_primitive_of_node.address;
  globals.draws = draws.address;
  globals.materials = materials.address;
  globals.material_extensions = material_extensions.address;
  globals.lights = lights.address;
  globals.uvs = uvs.address;
  globals.extras = extras.address;
  globals.indices = indices.address;
  globals.parts = parts.address;
  globals.clusters = clusters.address;
  globals.level_groups = level_groups.address;
  globals.cluster_triangles = cluster_triangles.address;
  globals.ray_boxes = ray_boxes.address;
  globals.ray_box_count = ray_box_count;
  globals.primitive_count = static_cast<uint32_t>(geometry.size());
  globals.cluster_instances = cluster_instances.address;
  globals.light_count = light_count;
  globals.part_count = part_count;
}

GpuScene::GpuScene(gpu::Device& device, const scene::Scene& scene, const scene::Derived& derived,
                   VkDescriptorSetLayout textures_layout, const gpu::EnvironmentTextures& environment,
                   const SceneUses& uses, const GpuScene* before) {
  gpu::LoaderCommands loader(device);
  world_count = uses.worlds;
  refracts = uses.refracts && any_transmissive(scene);
  mirrored = mirrored_at_rest(scene);
  draw_list = DrawList::collect(scene, mirrored, {}, refracts);
  is_path_traced = uses.path_traced;
  node_count = static_cast<uint32_t>(scene.nodes.size());

  scene::ClusteredGeometry with_copies;
  std::vector<scene::DeformedNode> deformed_nodes;
  if (std::any_of(scene.nodes.begin(), scene.nodes.end(), scene::is_deformed)) {
    with_copies = derived.clusters;
    deformed_nodes = scene::add_deformed_copies(scene, with_copies);
  }
  const scene::ClusteredGeometry& clustered = deformed_nodes.empty() ? derived.clusters : with_copies;
  vertices.resize(deformed_nodes.empty() ? 1 : world_count);
  instance_vertices = find_instance_vertices(scene, deformed_nodes, clustered);
  deformed = DeformedShapes(device, loader, scene, std::move(deformed_nodes), clustered);
  if (!deformed.nodes.empty()) {
    for (uint32_t world = 0; world < world_count; ++world)
      deformed_worlds.emplace_back().weights = upload_array(device, loader, scene.morph_weights);
  }
  geometry = clustered.primitives;
  const VkBufferUsageFlags geometry_usage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
      (device.traces_rays() ? VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR : 0);
  // A turn after each large array.
  TextureUploads texture_uploads(device, scene, uses.anisotropy, before ? &before->scene_textures : nullptr);
  texture_uploads.submit_some();
  for (VertexBuffers& of_world : vertices)
    of_world.positions =
        upload_in_order(device, loader, scene.positions, clustered.source_vertices, geometry_usage);
  texture_uploads.submit_some();
  const uint64_t index_count =
      needs_indices(scene, clustered, uses, device.traces_rays()) ? scene::index_count(clustered) : 0;
  indices = upload_indices(device, loader, scene::ClusterIndices(scene, clustered), index_count,
                           geometry_usage | VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  // A software device builds these for long; the builds run on another thread.
  std::optional<gpu::MeshBuilds> mesh_builds;
  if (device.traces_rays()) {
    std::vector<gpu::Buffer*> inputs{&vertices[0].positions, &indices};
    static_assert(sizeof(scene::RayAabb) == sizeof(gpu_types::RayBoxRecord) &&
                  sizeof(scene::RayAabb) == gpu::kBoxStride);
    if (uses.rays_to_boxes && !clustered.ray_boxes.empty()) {
      ray_boxes = upload_array(device, loader, clustered.ray_boxes, geometry_usage);
      inputs.push_back(&ray_boxes);
      ray_box_count = static_cast<uint32_t>(clustered.ray_boxes.size());
    }
    loader.submit();
    mesh_builds.emplace(device, static_geometry(scene, *this), std::move(inputs));
  }
  texture_uploads.submit_some();
  static_assert(sizeof(scene::TangentFrame) == sizeof(gpu_types::FrameRecord) &&
                sizeof(scene::VertexExtras) == sizeof(gpu_types::ExtrasRecord));
  const auto upload_vertices = [&](const auto& values) {
    return upload_in_order(device, loader, values, clustered.source_vertices,
                           VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  };
  for (VertexBuffers& of_world : vertices) {
    of_world.frames = upload_vertices(scene.frames);
    texture_uploads.submit_some();
    if (!scene.tangents.empty()) {
      of_world.tangents = upload_vertices(scene.tangents);
    } else if (deformed.record_count > 0) {
      // Deformation writes tangents, even where the file's are not worth storing.
      const std::vector<scene::TangentXy> room(clustered.source_vertices.size(), scene::kNoTangent);
      of_world.tangents = upload_array(device, loader, room);
    }
  }
  uvs = upload_vertices(scene.uvs);
  texture_uploads.submit_some();
  if (!scene.extras.empty()) extras = upload_vertices(scene.extras);
  clusters = upload_array(device, loader, cluster_records(clustered));
  level_groups = upload_array(device, loader, level_group_records(clustered));
  cluster_triangles = upload_array(device, loader, clustered.triangles);

  filters_anisotropically = uses.anisotropy > 1 && device.report().anisotropy;
  const MaterialRecords records =
      material_records(scene.materials, texture_facts(scene, filters_anisotropically));
  materials = upload_array(device, loader, records.materials);
  scene_material_count = static_cast<uint32_t>(records.materials.size());
  scene_primitive_count = static_cast<uint32_t>(geometry.size());
  has_extensions = !records.extensions.empty();
  has_textures = any_textured(scene.materials);
  has_second_uv = any_second_uv(scene.materials);
  material_flags = optional_flags(scene.materials);
  material_extensions = upload_array(device, loader, records.extensions);

  primitive_shift_of_node.assign(node_count, 0);
  for (const scene::DeformedNode& shape : deformed.nodes) {
    primitive_shift_of_node[shape.node] =
        shape.first_primitive - scene.meshes[scene.nodes[shape.node].mesh].first_primitive;
  }
  const std::vector<gpu_types::PrimitiveRecord> primitive_records = make_primitive_records(scene, *this);
  for (VertexBuffers& of_world : vertices)
    of_world.primitives = upload_array(device, loader, primitive_records);

  std::vector<gpu_types::LightRecord> light_records;
  sun = uses.sun;
  lamp_count = uses.lamps;
  const std::vector<scene::PlacedLight> placed_lights = drawn_lights(scene, nullptr, {lamp_count, sun});
  light_at_node.assign(node_count, FIRE3DV_NO_INDEX);
  for (const scene::PlacedLight& placed : placed_lights) {
    if (placed.node != scene::kNone) light_at_node[placed.node] = static_cast<uint32_t>(light_records.size());
    light_records.push_back(light_record(placed.light, placed.node));
  }
  std::vector<uint32_t> first_primitives(node_count, 0), instance_indices(node_count, FIRE3DV_NO_INDEX);
  for (uint32_t n = 0; n < node_count; ++n) {
    const scene::Node& node = scene.nodes[n];
    mesh_node_count += node.mesh != scene::kNone ? 1 : 0;
    if (node.mesh != scene::kNone)
      first_primitives[n] = primitive_at(n, scene.meshes[node.mesh].first_primitive);
  }
  light_count = static_cast<uint32_t>(light_records.size());
  lights = upload_array(device, loader, light_records);
  light_of_node = upload_array(device, loader, light_at_node);
  first_primitive_of_node = upload_array(device, loader, first_primitives);

  Parts all_parts = collect_parts(scene, derived.casters, clustered.clusters, *this);
  part_count = static_cast<uint32_t>(all_parts.parts.size());
  planar_casters = std::move(all_parts.planar);
  first_part_of_node = std::move(all_parts.first_of_node);
  for (const gpu_types::PartRecord& part : all_parts.parts) {
    part_flags.push_back(part.flags);
    has_forward_only |= (part.flags & FIRE3DV_PART_FORWARD_ONLY) != 0;
    has_masked |= (part.flags & FIRE3DV_PART_MASK) != 0;
  }
  has_blended_triangles = any_blended_triangles(scene);
  cluster_instance_count = static_cast<uint32_t>(all_parts.clusters.size());
  lod0_cluster_instance_count = all_parts.lod0_cluster_count;
  for (uint32_t i = 0; i < lod0_cluster_instance_count; ++i)
    lod0_triangle_count += all_parts.clusters[i].counts >> 16;
  parts = upload_array(device, loader, all_parts.parts);
  cluster_instances = upload_array(device, loader, all_parts.clusters);

  draws = upload_array(device, loader, draw_records(scene, *this));
  create_node_buffer(device, loader);

  if (device.traces_rays()) {
    loader.submit();  // keeps the order of recording
    blas_of_mesh = mesh_builds->finish(blas_report);
    mesh_builds.reset();
    for (uint32_t world = 0; world < deformed_worlds.size(); ++world)
      deformed_worlds[world].levels = gpu::DeformedLevels(device, deformed_geometry(scene, *this, world));
    std::vector<VkDeviceAddress> blas_of_node(node_count, 0);
    for (uint32_t n = 0; n < node_count; ++n) {
      const scene::Node& node = scene.nodes[n];
      if (node.mesh != scene::kNone) blas_of_node[n] = blas_of_mesh[node.mesh].address;
    }
    for (size_t i = 0; i < deformed.nodes.size(); ++i)
      blas_of_node[deformed.nodes[i].node] = deformed_worlds[0].levels.address(i);
    const std::vector<gpu_types::AffineRows> transforms = first_transforms(node_count);
    std::vector<VkAccelerationStructureInstanceKHR> instance_records;
    instance_at_node.assign(node_count, FIRE3DV_NO_INDEX);
    for (uint32_t n = 0; n < node_count; ++n) {
      if (!blas_of_node[n]) continue;
      // Skinned nodes have static instances, which the transforms pass skips.
      instance_at_node[n] = static_cast<uint32_t>(instance_records.size());
      if (transform_index_of(scene, n) == n) instance_indices[n] = instance_at_node[n];
      instance_records.push_back(instance_record(n, blas_of_node[n]));
      std::memcpy(&instance_records.back().transform, &transforms[transform_index_of(scene, n)],
                  sizeof(VkTransformMatrixKHR));
    }
    instance_count = static_cast<uint32_t>(instance_records.size());
    instance_bytes = instance_count * sizeof(instance_records[0]);
    instance_records.resize(size_t{world_count} * instance_count);
    for (uint32_t world = 1; world < world_count; ++world) {
      VkAccelerationStructureInstanceKHR* const of_world =
          instance_records.data() + size_t{world} * instance_count;
      std::copy_n(instance_records.begin(), instance_count, of_world);
      for (size_t i = 0; i < deformed.nodes.size(); ++i) {
        const uint32_t instance = instance_at_node[deformed.nodes[i].node];
        if (instance != FIRE3DV_NO_INDEX)
          of_world[instance].accelerationStructureReference = deformed_worlds[world].levels.address(i);
      }
    }
    instances = upload_array(device, loader, instance_records, geometry_usage);
    top_level = gpu::TopLevels(device, world_count, instance_count, uses.rays);
  }
  instance_of_node = upload_array(device, loader, instance_indices);
  scene_textures = texture_uploads.finish();
  if (scene.sky_texture != scene::kNone)
    sky = {scene.sky_texture, scene.images[scene.textures[scene.sky_texture].image].height};
  loader.finish();
  textures = gpu::BindlessTextures(device, textures_layout, scene_textures.sampled, environment);
}

}  // namespace fire3dv::passes
