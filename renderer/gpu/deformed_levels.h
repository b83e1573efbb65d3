// Bottom-level acceleration structures of deformed meshes. The first frame builds them, later frames update
// them; an update keeps the tree and refits its boxes.
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
  VkDeviceAddress address(size_t mesh) const { return addresses_[mesh]; }  // 0: no structure
  Buffer& storage() { return storage_; }
  Buffer& scratch() { return scratch_; }
  // Records the build or the update of all structures. The caller declares storage() and scratch() as
  // build_write and the geometries' buffers as build_input.
  void record(VkCommandBuffer commands);

 private:
  Device* device_ = nullptr;
  Buffer storage_, scratch_;  // separate ranges per mesh, so that all builds run in parallel
  std::vector<AccelerationHandle> handles_;
  std::vector<VkDeviceAddress> addresses_;
  std::vector<MeshBuild> builds_;
  bool built_ = false;
};

}  // namespace fire3dv::gpu
