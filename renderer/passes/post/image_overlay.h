// Common bindings of passes that draw over a finished image: the image and the scene.
#pragma once

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view.h"

namespace fire3dv::passes {

// A camera view whose visibility buffer is complete.
struct InspectedView {
  const scene::Scene& scene;
  GpuScene& gpu_scene;
  gpu::Buffer& visibility;
  const View& view;
  VkDeviceAddress globals;
  VkExtent2D extent;
};

class ImageOverlay {
 public:
  ImageOverlay(gpu::Device& device, VkDescriptorSetLayout scene_set_layout);

  void draw_on(Targets& targets, const gpu::Image& image);
  VkPipelineLayout layout() const { return layout_.get(); }

  template <typename Push>
  void begin(VkCommandBuffer commands, const gpu::Pipeline& pipeline, const GpuScene& scene,
             const Push& push) const {
    static_assert(sizeof(Push) <= gpu::kPushConstantBytes);
    begin(commands, pipeline, scene, &push, sizeof(Push));
  }

 private:
  void begin(VkCommandBuffer commands, const gpu::Pipeline& pipeline, const GpuScene& scene, const void* push,
             uint32_t push_bytes) const;

  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;  // of the targets
};

}  // namespace fire3dv::passes
