// Bottom-level acceleration structures of meshes whose vertices move: built by the first frame that uses
// them, updated by later ones. An update keeps the tree and fits its boxes anew.
#pragma once

#include <vector>

#include "renderer/gpu/acceleration.h"

namespace fire3dv::gpu {

class DeformedLevels {
 public:
  DeformedLevels() = default;
  // A mesh without triangles has no structure.
  DeformedLevels(Device& device, const std::vector<std::vector<TriangleGeometry>>& meshes);

  bool empty() const { return builds_.empty(); }
  VkDeviceAddress address(size_t mesh) const { return addresses_[mesh]; }  // 0: it has none
  Buffer& storage() { return storage_; }
  Buffer& scratch() { return scratch_; }
  // Builds or updates all of them. The caller declares storage() and scratch() as build_write and what the
  // geometries point to as build_input.
  void record(VkCommandBuffer commands);

 private:
  Device* device_ = nullptr;
  Buffer storage_, scratch_;  // pieces of both for each mesh, so that all are built side by side
  std::vector<AccelerationHandle> handles_;
  std::vector<VkDeviceAddress> addresses_;
  std::vector<MeshBuild> builds_;
  bool built_ = false;
};

}  // namespace fire3dv::gpu
