#include "renderer/gpu/acceleration.h"

#include <algorithm>

#include "renderer/gpu/pipelines/pipeline.h"

namespace fire3dv::gpu {
namespace {

constexpr VkDeviceSize kMaxCopiedInSoftware = 8 << 20;

VkDeviceAddress align_scratch(VkDeviceAddress value, VkDeviceAddress alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

VkDeviceSize scratch_alignment(const Device& device) {
  return std::max(1u, device.acceleration_limits().minAccelerationStructureScratchOffsetAlignment);
}

AccelerationHandle create_handle(Device& device, const Buffer& storage, VkDeviceSize offset,
                                 VkDeviceSize size, VkAccelerationStructureTypeKHR type) {
  VkAccelerationStructureCreateInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
  info.buffer = storage.get();
  info.offset = offset;
  info.size = size;
  info.type = type;
  VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
  FIRE3DV_VK(device.functions().create_acceleration_structure(device.handle(), &info, nullptr, &handle));
  return AccelerationHandle(device, handle);
}

VkDeviceAddress address_of(Device& device, const AccelerationHandle& structure) {
  VkAccelerationStructureDeviceAddressInfoKHR info{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
  info.accelerationStructure = structure.get();
  return device.functions().get_acceleration_structure_address(device.handle(), &info);
}

AccelerationStructure create_bottom_level(Device& device, VkDeviceSize size, Memory memory = Memory::device) {
  AccelerationStructure structure;
  structure.storage =
      create_buffer(device, size, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, memory);
  structure.handle =
      create_handle(device, structure.storage, 0, size, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
  structure.address = address_of(device, structure.handle);
  return structure;
}

// One structure holds either boxes or triangles.
bool is_of_boxes(const std::vector<TriangleGeometry>& mesh) {
  return std::any_of(mesh.begin(), mesh.end(), [](const TriangleGeometry& g) { return g.boxes != 0; });
}

VkAccelerationStructureGeometryKHR instance_geometry(VkDeviceAddress instances) {
  VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
  geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  geometry.geometry.instances = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR};
  geometry.geometry.instances.data.deviceAddress = instances;
  return geometry;
}

VkAccelerationStructureBuildGeometryInfoKHR top_level_info(const VkAccelerationStructureGeometryKHR& geometry,
                                                           Rays rays) {
  VkAccelerationStructureBuildGeometryInfoKHR info{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
  info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
  info.flags = rays == Rays::few ? VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR
                                 : VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
  info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
  info.geometryCount = 1;
  info.pGeometries = &geometry;
  return info;
}

constexpr VkDeviceSize kStructureAlignment = 256;  // Vulkan's alignment of a structure's offset in its
                                                   // storage
constexpr VkBuildAccelerationStructureFlagsKHR kDeformedFlags =
    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;

bool has_triangles(const std::vector<TriangleGeometry>& mesh) {
  return std::any_of(mesh.begin(), mesh.end(),
                     [](const TriangleGeometry& g) { return g.triangle_count > 0; });
}

}  // namespace
bool traces_to_boxes(const Device& device) {
  return device.ray_query() && uses_cpu_variants(device);
}

MeshBuild describe_mesh(Device& device, const std::vector<TriangleGeometry>& mesh,
                        VkBuildAccelerationStructureFlagsKHR flags) {
  MeshBuild build;
  const bool of_boxes = is_of_boxes(mesh);
  std::vector<uint32_t> max_primitives;
  for (const TriangleGeometry& triangles : mesh) {
    VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry.flags = triangles.opaque ? VK_GEOMETRY_OPAQUE_BIT_KHR : 0;
    if (of_boxes) {
      geometry.geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
      geometry.geometry.aabbs = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR};
      geometry.geometry.aabbs.data.deviceAddress = triangles.boxes;
      geometry.geometry.aabbs.stride = kBoxStride;
      build.geometries.push_back(geometry);
      build.ranges.push_back({triangles.box_count, 0, 0, 0});
      max_primitives.push_back(triangles.box_count);
      continue;
    }
    VkAccelerationStructureGeometryTrianglesDataKHR& data = geometry.geometry.triangles;
    data = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR};
    data.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    data.vertexData.deviceAddress = triangles.positions;
    data.vertexStride = 3 * sizeof(float);
    data.maxVertex = triangles.vertex_count ? triangles.vertex_count - 1 : 0;
    data.indexType = VK_INDEX_TYPE_UINT32;
    data.indexData.deviceAddress = triangles.indices;
    build.geometries.push_back(geometry);
    build.ranges.push_back({triangles.triangle_count, 0, 0, 0});
    max_primitives.push_back(triangles.triangle_count);
  }
  build.info.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
  build.info.flags = flags;
  build.info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
  build.info.geometryCount = static_cast<uint32_t>(build.geometries.size());
  build.info.pGeometries = build.geometries.data();
  device.functions().get_build_sizes(device.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                     &build.info, max_primitives.data(), &build.sizes);
  return build;
}

MeshBuilds::MeshBuilds(Device& device, std::span<const std::vector<TriangleGeometry>> meshes,
                       std::vector<Buffer*> inputs)
    : device_(device), inputs_(std::move(inputs)), loader_(device), built_(meshes.size()) {
  create(meshes);
  if (builds_.empty()) return;
  VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  info.queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
  info.queryCount = static_cast<uint32_t>(builds_.size());
  VkQueryPool queries = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateQueryPool(device.handle(), &info, nullptr, &queries));
  compact_sizes_ = QueryPool(device, queries);
  vkResetQueryPool(device.handle(), queries, 0, info.queryCount);
  for (size_t build = 0; build < builds_.size(); ++build) record(build);
  loader_.submit();
}

void MeshBuilds::create(std::span<const std::vector<TriangleGeometry>> meshes) {
  const bool in_software = device_.report().type == DeviceType::software;
  VkDeviceSize scratch_size = 0;
  std::vector<std::span<std::byte>> to_be_written;
  for (uint32_t i = 0; i < meshes.size(); ++i) {
    if (meshes[i].empty()) continue;
    builds_.push_back(describe_mesh(device_, meshes[i],
                                    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
                                        VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR));
    mesh_of_build_.push_back(i);
    const VkAccelerationStructureBuildSizesInfoKHR& sizes = builds_.back().sizes;
    scratch_size = std::max(scratch_size, sizes.buildScratchSize);
    built_[i] = create_bottom_level(device_, sizes.accelerationStructureSize, filled_memory(device_));
    if (in_software) to_be_written.emplace_back(built_[i].storage.mapped, built_[i].storage.size_bytes);
  }
  if (builds_.empty()) return;
  touching_ = prefault(std::move(to_be_written));
  // The builds share one scratch buffer and run in sequence: loading is bound by the disk and the CPU.
  scratch_ = create_buffer(device_, scratch_size + scratch_alignment(device_),
                           VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Memory::device);
}

void MeshBuilds::record(size_t build) {
  MeshBuild& mesh = builds_[build];
  AccelerationStructure& structure = built_[mesh_of_build_[build]];
  mesh.info.dstAccelerationStructure = structure.handle.get();
  mesh.info.pGeometries = mesh.geometries.data();  // the vector of builds has moved them
  mesh.info.scratchData.deviceAddress = align_scratch(scratch_.address, scratch_alignment(device_));
  const VkAccelerationStructureBuildRangeInfoKHR* ranges = mesh.ranges.data();
  std::vector<Use> uses{Use(scratch_, access::build_write), Use(structure.storage, access::build_write)};
  for (Buffer* input : inputs_) uses.emplace_back(*input, access::build_input);
  loader_.recorder().pass("blas", uses, [&](VkCommandBuffer commands) {
    device_.functions().cmd_build_acceleration_structures(commands, 1, &mesh.info, &ranges);
  });
  loader_.recorder().pass("blas size", {Use(structure.storage, access::build_read)},
                          [&](VkCommandBuffer commands) {
                            const VkAccelerationStructureKHR handle = structure.handle.get();
                            device_.functions().cmd_write_acceleration_structures_properties(
                                commands, 1, &handle, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                                compact_sizes_.get(), static_cast<uint32_t>(build));
                          });
}

std::vector<AccelerationStructure> MeshBuilds::finish(BlasBuildReport& report) {
  loader_.finish();
  touching_ = {};
  for (const MeshBuild& build : builds_) report.bytes_built += build.sizes.accelerationStructureSize;
  // A software device gets memory page by page on first write. Compacting a large structure therefore costs
  // as much as it saves.
  if (device_.report().type == DeviceType::software && report.bytes_built > kMaxCopiedInSoftware) {
    report.bytes_compacted = report.bytes_built;
  } else if (!builds_.empty()) {
    compact(report);
  }
  return std::move(built_);
}

void MeshBuilds::compact(BlasBuildReport& report) {
  std::vector<VkDeviceSize> sizes(builds_.size());
  FIRE3DV_VK(vkGetQueryPoolResults(device_.handle(), compact_sizes_.get(), 0,
                                   static_cast<uint32_t>(sizes.size()), sizes.size() * sizeof(VkDeviceSize),
                                   sizes.data(), sizeof(VkDeviceSize),
                                   VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  for (size_t b = 0; b < builds_.size(); ++b) {
    AccelerationStructure& structure = built_[mesh_of_build_[b]];
    AccelerationStructure smaller = create_bottom_level(device_, sizes[b]);
    loader_.recorder().pass(
        "blas compact",
        {Use(structure.storage, access::build_read), Use(smaller.storage, access::build_write)},
        [&](VkCommandBuffer commands) {
          VkCopyAccelerationStructureInfoKHR copy{VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR};
          copy.src = structure.handle.get();
          copy.dst = smaller.handle.get();
          copy.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
          device_.functions().cmd_copy_acceleration_structure(commands, &copy);
        });
    report.bytes_compacted += sizes[b];
    structure = std::move(smaller);  // the large structure retires after the copy
  }
  loader_.finish();
}

TopLevels::TopLevels(Device& device, uint32_t worlds, uint32_t max_instances, Rays rays)
    : device_(&device), rays_(rays) {
  const VkAccelerationStructureGeometryKHR geometry = instance_geometry(0);
  const VkAccelerationStructureBuildGeometryInfoKHR info = top_level_info(geometry, rays);
  VkAccelerationStructureBuildSizesInfoKHR sizes{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
  device.functions().get_build_sizes(device.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info,
                                     &max_instances, &sizes);
  const VkDeviceSize size = std::max<VkDeviceSize>(sizes.accelerationStructureSize, 64);
  const VkDeviceSize stride = align_scratch(size, kStructureAlignment);
  storage_ = create_buffer(device, (worlds - 1) * stride + size,
                           VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, Memory::device);
  for (uint32_t world = 0; world < worlds; ++world) {
    Structure& structure = structures_.emplace_back();
    structure.handle =
        create_handle(device, storage_, world * stride, size, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    structure.address = address_of(device, structure.handle);
  }
  const VkDeviceSize alignment = scratch_alignment(device);
  scratch_stride_ = align_scratch(sizes.buildScratchSize, alignment);
  scratch_ = create_buffer(device, (worlds - 1) * scratch_stride_ + sizes.buildScratchSize + alignment,
                           VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Memory::device);
  scratch_address_ = align_scratch(scratch_.address, alignment);
}

void TopLevels::record_build(VkCommandBuffer commands, VkDeviceAddress instances, uint32_t count) const {
  const VkAccelerationStructureBuildRangeInfoKHR range{count, 0, 0, 0};
  std::vector<VkAccelerationStructureGeometryKHR> geometries;
  std::vector<VkAccelerationStructureBuildGeometryInfoKHR> infos;
  geometries.reserve(structures_.size());  // the infos point to them
  for (uint32_t world = 0; world < structures_.size(); ++world) {
    geometries.push_back(instance_geometry(instances + VkDeviceSize{world} * count *
                                                           sizeof(VkAccelerationStructureInstanceKHR)));
    VkAccelerationStructureBuildGeometryInfoKHR& info =
        infos.emplace_back(top_level_info(geometries.back(), rays_));
    info.dstAccelerationStructure = structures_[world].handle.get();
    info.scratchData.deviceAddress = scratch_address_ + world * scratch_stride_;
  }
  const std::vector<const VkAccelerationStructureBuildRangeInfoKHR*> ranges(infos.size(), &range);
  device_->functions().cmd_build_acceleration_structures(commands, static_cast<uint32_t>(infos.size()),
                                                         infos.data(), ranges.data());
}

DeformedLevels::DeformedLevels(Device& device, const std::vector<std::vector<TriangleGeometry>>& meshes)
    : device_(&device), addresses_(meshes.size(), 0) {
  const VkDeviceSize alignment = scratch_alignment(device);
  std::vector<size_t> mesh_of_build;
  std::vector<VkDeviceSize> offsets, scratch_offsets;
  VkDeviceSize storage_size = 0, scratch_size = 0;
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (!has_triangles(meshes[m])) continue;
    builds_.push_back(describe_mesh(device, meshes[m], kDeformedFlags));
    const VkAccelerationStructureBuildSizesInfoKHR& sizes = builds_.back().sizes;
    mesh_of_build.push_back(m);
    offsets.push_back(storage_size);
    scratch_offsets.push_back(scratch_size);
    storage_size += align_scratch(sizes.accelerationStructureSize, kStructureAlignment);
    scratch_size += align_scratch(std::max(sizes.buildScratchSize, sizes.updateScratchSize), alignment);
  }
  if (builds_.empty()) return;
  storage_ = create_buffer(device, storage_size, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
                           Memory::device);
  scratch_ =
      create_buffer(device, scratch_size + alignment, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Memory::device);
  for (size_t b = 0; b < builds_.size(); ++b) {
    handles_.push_back(create_handle(device, storage_, offsets[b], builds_[b].sizes.accelerationStructureSize,
                                     VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR));
    addresses_[mesh_of_build[b]] = address_of(device, handles_.back());
    MeshBuild& build = builds_[b];
    build.info.pGeometries = build.geometries.data();  // the vector of builds has moved them
    build.info.dstAccelerationStructure = handles_.back().get();
    build.info.scratchData.deviceAddress = align_scratch(scratch_.address, alignment) + scratch_offsets[b];
  }
}

void DeformedLevels::record(VkCommandBuffer commands) {
  std::vector<VkAccelerationStructureBuildGeometryInfoKHR> infos;
  std::vector<const VkAccelerationStructureBuildRangeInfoKHR*> ranges;
  for (const MeshBuild& build : builds_) {
    infos.push_back(build.info);
    if (built_) {
      infos.back().mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
      infos.back().srcAccelerationStructure = build.info.dstAccelerationStructure;
    }
    ranges.push_back(build.ranges.data());
  }
  device_->functions().cmd_build_acceleration_structures(commands, static_cast<uint32_t>(infos.size()),
                                                         infos.data(), ranges.data());
  built_ = true;
}

}  // namespace fire3dv::gpu
