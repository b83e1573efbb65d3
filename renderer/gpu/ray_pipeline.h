// A ray-tracing pipeline of one ray-generation shader, one miss shader and one any-hit shader for triangles
// that are not opaque, with its shader binding table.
#pragma once

#include <string_view>

#include "renderer/gpu/pipeline.h"
#include "renderer/gpu/resources.h"

namespace fire3dv::gpu {

class RayPipeline {
 public:
  RayPipeline() = default;
  RayPipeline(Device& device, VkPipelineLayout layout, std::string_view raygen, std::string_view miss,
              std::string_view any_hit);

  // arguments: address of a VkTraceRaysIndirectCommandKHR. Sets and push constants are bound by the caller.
  void trace(VkCommandBuffer commands, VkDeviceAddress arguments) const;
  VkPipeline get() const { return pipeline_.get(); }

 private:
  Device* device_ = nullptr;
  Pipeline pipeline_;
  Buffer table_;
  VkStridedDeviceAddressRegionKHR raygen_{}, miss_{}, hit_{};
};

}  // namespace fire3dv::gpu
