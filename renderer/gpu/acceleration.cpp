#include "renderer/gpu/acceleration.h"

#include <algorithm>

namespace fire3dv::gpu {
namespace {

constexpr VkDeviceSize kMostCopiedInSoftware = 8 << 20;

VkDeviceAddress align_up(VkDeviceAddress value, VkDeviceAddress alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

AccelerationStructure create_structure(Device& device, VkAccelerationStructureTypeKHR type,
                                       VkDeviceSize size) {
  AccelerationStructure structure;
  structure.storage =
      create_buffer(device, size, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, Memory::device);
  VkAccelerationStructureCreateInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
  info.buffer = structure.storage.get();
  info.size = size;
  info.type = type;
  VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
  FIRE3DV_VK(device.functions().create_acceleration_structure(device.handle(), &info, nullptr, &handle));
  structure.handle = AccelerationHandle(device, handle);
  VkAccelerationStructureDeviceAddressInfoKHR address{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
  address.accelerationStructure = handle;
  structure.address = device.functions().get_acceleration_structure_address(device.handle(), &address);
  return structure;
}

}  // namespace

MeshBuild describe_mesh(Device& device, const std::vector<TriangleGeometry>& mesh,
                        VkBuildAccelerationStructureFlagsKHR flags) {
  MeshBuild build;
  std::vector<uint32_t> max_triangles;
  for (const TriangleGeometry& triangles : mesh) {
    VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry.flags = triangles.opaque ? VK_GEOMETRY_OPAQUE_BIT_KHR : 0;
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
    max_triangles.push_back(triangles.triangle_count);
  }
  build.info.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
  build.info.flags = flags;
  build.info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
  build.info.geometryCount = static_cast<uint32_t>(build.geometries.size());
  build.info.pGeometries = build.geometries.data();
  device.functions().get_build_sizes(device.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                     &build.info, max_triangles.data(), &build.sizes);
  return build;
}

std::vector<AccelerationStructure> build_meshes(Device& device, LoaderCommands& loader,
                                                std::span<const std::vector<TriangleGeometry>> meshes,
                                                Buffer& positions, Buffer& indices, BlasBuildReport& report) {
  std::vector<AccelerationStructure> built(meshes.size());
  std::vector<MeshBuild> builds;
  std::vector<uint32_t> mesh_of_build;
  VkDeviceSize scratch_size = 0;
  for (uint32_t i = 0; i < meshes.size(); ++i) {
    if (meshes[i].empty()) continue;
    builds.push_back(describe_mesh(device, meshes[i],
                                   VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
                                       VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR));
    mesh_of_build.push_back(i);
    scratch_size = std::max(scratch_size, builds.back().sizes.buildScratchSize);
  }
  if (builds.empty()) return built;

  // One build after the other through one scratch buffer: loading is bound by the disk and the CPU, not by
  // this.
  const VkDeviceSize alignment =
      std::max(1u, device.acceleration_limits().minAccelerationStructureScratchOffsetAlignment);
  Buffer scratch =
      create_buffer(device, scratch_size + alignment, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Memory::device);

  VkQueryPoolCreateInfo query_info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  query_info.queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
  query_info.queryCount = static_cast<uint32_t>(builds.size());
  VkQueryPool query_handle = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateQueryPool(device.handle(), &query_info, nullptr, &query_handle));
  const QueryPool queries(device, query_handle);
  vkResetQueryPool(device.handle(), query_handle, 0, query_info.queryCount);

  for (size_t b = 0; b < builds.size(); ++b) {
    MeshBuild& build = builds[b];
    AccelerationStructure& structure = built[mesh_of_build[b]];
    structure = create_structure(device, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                 build.sizes.accelerationStructureSize);
    report.bytes_built += build.sizes.accelerationStructureSize;
    build.info.dstAccelerationStructure = structure.handle.get();
    build.info.pGeometries = build.geometries.data();  // the vector of builds has moved them
    build.info.scratchData.deviceAddress = align_up(scratch.address, alignment);
    const VkAccelerationStructureBuildRangeInfoKHR* ranges = build.ranges.data();
    loader.recorder().pass("blas",
                           {Use(positions, access::build_input), Use(indices, access::build_input),
                            Use(scratch, access::build_write), Use(structure.storage, access::build_write)},
                           [&](VkCommandBuffer commands) {
                             device.functions().cmd_build_acceleration_structures(commands, 1, &build.info,
                                                                                  &ranges);
                           });
    loader.recorder().pass(
        "blas size", {Use(structure.storage, access::build_read)}, [&](VkCommandBuffer commands) {
          const VkAccelerationStructureKHR handle = structure.handle.get();
          device.functions().cmd_write_acceleration_structures_properties(
              commands, 1, &handle, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, query_handle,
              static_cast<uint32_t>(b));
        });
  }
  loader.finish();
  // A software device gives memory page by page to what is written: a copy of much wins nothing and costs as
  // much again.
  if (device.report().type == DeviceType::software && report.bytes_built > kMostCopiedInSoftware) {
    report.bytes_compacted = report.bytes_built;
    return built;
  }

  std::vector<VkDeviceSize> compacted(builds.size());
  FIRE3DV_VK(vkGetQueryPoolResults(device.handle(), query_handle, 0, query_info.queryCount,
                                   compacted.size() * sizeof(VkDeviceSize), compacted.data(),
                                   sizeof(VkDeviceSize), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  for (size_t b = 0; b < builds.size(); ++b) {
    AccelerationStructure& structure = built[mesh_of_build[b]];
    AccelerationStructure smaller =
        create_structure(device, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, compacted[b]);
    loader.recorder().pass(
        "blas compact",
        {Use(structure.storage, access::build_read), Use(smaller.storage, access::build_write)},
        [&](VkCommandBuffer commands) {
          VkCopyAccelerationStructureInfoKHR copy{VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR};
          copy.src = structure.handle.get();
          copy.dst = smaller.handle.get();
          copy.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
          device.functions().cmd_copy_acceleration_structure(commands, &copy);
        });
    report.bytes_compacted += compacted[b];
    structure = std::move(smaller);  // the large one retires after the copy
  }
  loader.finish();
  return built;
}

namespace {

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

}  // namespace

TopLevel::TopLevel(Device& device, uint32_t max_instances, Rays rays) : device_(&device), rays_(rays) {
  const VkAccelerationStructureGeometryKHR geometry = instance_geometry(0);
  const VkAccelerationStructureBuildGeometryInfoKHR info = top_level_info(geometry, rays);
  VkAccelerationStructureBuildSizesInfoKHR sizes{
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
  device.functions().get_build_sizes(device.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info,
                                     &max_instances, &sizes);
  structure_ = create_structure(device, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                                std::max<VkDeviceSize>(sizes.accelerationStructureSize, 64));
  const VkDeviceSize alignment =
      std::max(1u, device.acceleration_limits().minAccelerationStructureScratchOffsetAlignment);
  scratch_ = create_buffer(device, sizes.buildScratchSize + alignment, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                           Memory::device);
  scratch_address_ = align_up(scratch_.address, alignment);
}

void TopLevel::record_build(VkCommandBuffer commands, VkDeviceAddress instances, uint32_t count) const {
  const VkAccelerationStructureGeometryKHR geometry = instance_geometry(instances);
  VkAccelerationStructureBuildGeometryInfoKHR info = top_level_info(geometry, rays_);
  info.dstAccelerationStructure = structure_.handle.get();
  info.scratchData.deviceAddress = scratch_address_;
  const VkAccelerationStructureBuildRangeInfoKHR range{count, 0, 0, 0};
  const VkAccelerationStructureBuildRangeInfoKHR* ranges = &range;
  device_->functions().cmd_build_acceleration_structures(commands, 1, &info, &ranges);
}

}  // namespace fire3dv::gpu
