#include "renderer/gpu/deformed_levels.h"

#include <algorithm>

namespace fire3dv::gpu {
namespace {

constexpr VkDeviceSize kStructureAlignment = 256;  // Vulkan's alignment of a structure's offset in its
                                                   // storage
constexpr VkBuildAccelerationStructureFlagsKHR kFlags =
    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;

VkDeviceSize align_up(VkDeviceSize value, VkDeviceSize alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

bool has_triangles(const std::vector<TriangleGeometry>& mesh) {
  return std::any_of(mesh.begin(), mesh.end(),
                     [](const TriangleGeometry& g) { return g.triangle_count > 0; });
}

}  // namespace

DeformedLevels::DeformedLevels(Device& device, const std::vector<std::vector<TriangleGeometry>>& meshes)
    : device_(&device), addresses_(meshes.size(), 0) {
  const VkDeviceSize scratch_alignment =
      std::max(1u, device.acceleration_limits().minAccelerationStructureScratchOffsetAlignment);
  std::vector<size_t> mesh_of_build;
  std::vector<VkDeviceSize> offsets, scratch_offsets;
  VkDeviceSize storage_size = 0, scratch_size = 0;
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (!has_triangles(meshes[m])) continue;
    builds_.push_back(describe_mesh(device, meshes[m], kFlags));
    const VkAccelerationStructureBuildSizesInfoKHR& sizes = builds_.back().sizes;
    mesh_of_build.push_back(m);
    offsets.push_back(storage_size);
    scratch_offsets.push_back(scratch_size);
    storage_size += align_up(sizes.accelerationStructureSize, kStructureAlignment);
    scratch_size += align_up(std::max(sizes.buildScratchSize, sizes.updateScratchSize), scratch_alignment);
  }
  if (builds_.empty()) return;
  storage_ = create_buffer(device, storage_size, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
                           Memory::device);
  scratch_ = create_buffer(device, scratch_size + scratch_alignment, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                           Memory::device);
  for (size_t b = 0; b < builds_.size(); ++b) {
    VkAccelerationStructureCreateInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
    info.buffer = storage_.get();
    info.offset = offsets[b];
    info.size = builds_[b].sizes.accelerationStructureSize;
    info.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
    FIRE3DV_VK(device.functions().create_acceleration_structure(device.handle(), &info, nullptr, &handle));
    handles_.emplace_back(device, handle);
    VkAccelerationStructureDeviceAddressInfoKHR address{
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
    address.accelerationStructure = handle;
    addresses_[mesh_of_build[b]] =
        device.functions().get_acceleration_structure_address(device.handle(), &address);
    MeshBuild& build = builds_[b];
    build.info.pGeometries = build.geometries.data();  // the vector of builds has moved them
    build.info.dstAccelerationStructure = handle;
    build.info.scratchData.deviceAddress = align_up(scratch_.address, scratch_alignment) + scratch_offsets[b];
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
