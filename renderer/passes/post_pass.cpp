#include "renderer/passes/post_pass.h"

#include <array>

#include "renderer/gpu/bindless_textures.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

using gpu::Use;
namespace access = gpu::access;

PostPass::PostPass(gpu::Device& device, VkSampleCountFlagBits samples) : device_(device) {
  const VkDescriptorSetLayoutBinding bindings[] = {
      {FIRE3DV_BINDING_POST_HDR, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
      {FIRE3DV_BINDING_POST_OUT, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
  };
  VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  info.bindingCount = std::size(bindings);
  info.pBindings = bindings;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateDescriptorSetLayout(device.handle(), &info, nullptr, &set_layout));
  set_layout_ = gpu::SetLayout(device, set_layout);
  scene_layout_ = gpu::BindlessTextures::create_layout(device);
  layout_ = gpu::create_pipeline_layout(device, std::array{scene_layout_.get(), set_layout_.get()});
  pipeline_ = gpu::create_compute_pipeline(
      device, layout_.get(), samples == VK_SAMPLE_COUNT_1_BIT ? "post.comp" : "post_multisampled.comp");

  VkSamplerCreateInfo sampler_info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  VkSampler sampler = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSampler(device.handle(), &sampler_info, nullptr, &sampler));
  sampler_ = gpu::Sampler(device, sampler);
}

void PostPass::bind(const Targets& targets) {
  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1},
                                        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1}};
  VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool_info.maxSets = 1;
  pool_info.poolSizeCount = std::size(sizes);
  pool_info.pPoolSizes = sizes;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateDescriptorPool(device_.handle(), &pool_info, nullptr, &pool));
  pool_ = gpu::DescriptorPool(device_, pool);  // the old one retires to the frames that used it

  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool;
  allocate.descriptorSetCount = 1;
  const VkDescriptorSetLayout set_layout = set_layout_.get();
  allocate.pSetLayouts = &set_layout;
  FIRE3DV_VK(vkAllocateDescriptorSets(device_.handle(), &allocate, &set_));

  const VkDescriptorImageInfo hdr{sampler_.get(), targets.hdr.view.get(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkDescriptorImageInfo out{VK_NULL_HANDLE, targets.ldr.view.get(), VK_IMAGE_LAYOUT_GENERAL};
  VkWriteDescriptorSet writes[2] = {{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET}, {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET}};
  writes[0].dstSet = writes[1].dstSet = set_;
  writes[0].dstBinding = FIRE3DV_BINDING_POST_HDR;
  writes[1].dstBinding = FIRE3DV_BINDING_POST_OUT;
  writes[0].descriptorCount = writes[1].descriptorCount = 1;
  writes[0].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  writes[1].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  writes[0].pImageInfo = &hdr;
  writes[1].pImageInfo = &out;
  vkUpdateDescriptorSets(device_.handle(), 2, writes, 0, nullptr);
}

void PostPass::record(gpu::Recorder& recorder, Targets& targets, const PostSettings& settings) {
  gpu_types::PostPush push{};
  push.width = targets.extent.width;
  push.height = targets.extent.height;
  push.samples = targets.samples;
  push.exposure = settings.exposure;
  push.tone_map = settings.tone_map == ToneMap::reinhard ? FIRE3DV_TONE_MAP_REINHARD : FIRE3DV_TONE_MAP_NONE;
  recorder.pass("post", {Use(targets.hdr, access::compute_sample), Use(targets.ldr, access::compute_write, true)},
                [&](VkCommandBuffer commands) {
                  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
                  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 1, 1, &set_, 0,
                                          nullptr);
                  vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
                  vkCmdDispatch(commands, (push.width + 7) / 8, (push.height + 7) / 8, 1);
                });
}

}  // namespace fire3dv::passes
