// Ray-tracing pipeline with its shader binding table: one ray-generation, one miss and one any-hit shader.
// The any-hit shader serves triangles that are not opaque.
#pragma once

#include <string_view>

#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/resources.h"

namespace fire3dv::gpu {

class RayPipeline {
 public:
  RayPipeline() = default;
  RayPipeline(Device& device, VkPipelineLayout layout, std::string_view raygen, std::string_view miss,
              std::string_view any_hit);

  // arguments: address of a VkTraceRaysIndirectCommandKHR. The caller binds descriptor sets and push
  // constants.
  void trace(VkCommandBuffer commands, VkDeviceAddress arguments) const;
  VkPipeline get() const { return pipeline_.get(); }

 private:
  Device* device_ = nullptr;
  Pipeline pipeline_;
  Buffer table_;
  VkStridedDeviceAddressRegionKHR raygen_{}, miss_{}, hit_{};
};

}  // namespace fire3dv::gpu
