#include "renderer/passes/post/image_overlay.h"

#include <array>

#include "shaders/shared/bindings.h"

namespace fire3dv::passes {

ImageOverlay::ImageOverlay(gpu::Device& device, VkDescriptorSetLayout scene_set_layout) : device_(device) {
  const VkDescriptorSetLayoutBinding binding{FIRE3DV_BINDING_DISPLAY, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1,
                                             VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  set_layout_ = gpu::create_set_layout(device, {&binding, 1});
  layout_ = gpu::create_pipeline_layout(device, std::array{scene_set_layout, set_layout_.get()});
}

void ImageOverlay::draw_on(Targets& targets, const gpu::Image& image) {
  if (targets.overlay_view != image.view.get()) {
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1};
    targets.overlay_set = gpu::DescriptorSet(device_, set_layout_.get(), {&size, 1});
    const VkDescriptorImageInfo info{VK_NULL_HANDLE, image.view.get(), VK_IMAGE_LAYOUT_GENERAL};
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = targets.overlay_set.get();
    write.dstBinding = FIRE3DV_BINDING_DISPLAY;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    write.pImageInfo = &info;
    vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
    targets.overlay_view = image.view.get();
  }
  set_ = targets.overlay_set.get();
}

void ImageOverlay::begin(VkCommandBuffer commands, const gpu::Pipeline& pipeline, const GpuScene& scene,
                         const void* push, uint32_t push_bytes) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
  const VkDescriptorSet sets[] = {scene.textures.set(), set_};
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 2, sets, 0, nullptr);
  vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, push_bytes, push);
}

}  // namespace fire3dv::passes
