#include "renderer/passes/post/stale_overlay_pass.h"

#include <array>

#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

StaleOverlayPass::StaleOverlayPass(gpu::Device& device) : device_(device) {
  const VkDescriptorSetLayoutBinding binding{FIRE3DV_BINDING_FILTER_OUT, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1,
                                             VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  set_layout_ = gpu::create_set_layout(device, {&binding, 1});
  layout_ = gpu::create_pipeline_layout(device, std::array{set_layout_.get()});
  pipeline_ = gpu::create_compute_pipeline(device, layout_.get(), "stale_overlay.comp");
}

void StaleOverlayPass::bind(Targets& targets, const gpu::Image& image) const {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1};
  targets.stale_overlay_set = gpu::DescriptorSet(device_, set_layout_.get(), {&size, 1});
  const VkDescriptorImageInfo info{VK_NULL_HANDLE, image.view.get(), VK_IMAGE_LAYOUT_GENERAL};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = targets.stale_overlay_set.get();
  write.dstBinding = FIRE3DV_BINDING_FILTER_OUT;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  write.pImageInfo = &info;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
  targets.stale_overlay_view = image.view.get();
}

void StaleOverlayPass::record(gpu::Recorder& recorder, Targets& targets, gpu::Image& image,
                              state::Condition condition) {
  if (condition == state::Condition::live) return;
  if (targets.stale_overlay_view != image.view.get()) bind(targets, image);
  const gpu_types::StaleOverlayPush push{
      image.extent.width, image.extent.height,
      condition == state::Condition::late ? FIRE3DV_STALE_LATE : FIRE3DV_STALE_LOST};
  recorder.pass("held mark", {gpu::Use(image, gpu::access::compute_write)}, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1,
                            &targets.stale_overlay_set.get(), 0, nullptr);
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof push, &push);
    vkCmdDispatch(commands, (image.extent.width + 7) / 8, (image.extent.height + 7) / 8, 1);
  });
}

}  // namespace fire3dv::passes
