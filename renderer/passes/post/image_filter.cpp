#include "renderer/passes/post/image_filter.h"

#include <array>

#include "shaders/shared/bindings.h"

namespace fire3dv::passes {

using gpu::Use;
namespace access = gpu::access;

ImageFilter::ImageFilter(gpu::Device& device, std::string_view shader, VkFilter sampling) : device_(device) {
  const VkDescriptorSetLayoutBinding bindings[] = {
      {FIRE3DV_BINDING_FILTER_IN, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_COMPUTE_BIT,
       nullptr},
      {FIRE3DV_BINDING_FILTER_OUT, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
  };
  set_layout_ = gpu::create_set_layout(device, bindings);
  layout_ = gpu::create_pipeline_layout(device, std::array{set_layout_.get()});
  pipeline_ = gpu::create_compute_pipeline(device, layout_.get(), shader);

  VkSamplerCreateInfo sampler_info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  sampler_info.magFilter = sampler_info.minFilter = sampling;
  sampler_info.addressModeU = sampler_info.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  VkSampler sampler = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSampler(device.handle(), &sampler_info, nullptr, &sampler));
  sampler_ = gpu::Sampler(device, sampler);
}

gpu::DescriptorSet ImageFilter::bind(const gpu::Image& in, const gpu::Image& out) const {
  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1},
                                        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1}};
  gpu::DescriptorSet set(device_, set_layout_.get(), sizes);

  const VkDescriptorImageInfo in_info{sampler_.get(), in.view.get(),
                                      VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkDescriptorImageInfo out_info{VK_NULL_HANDLE, out.view.get(), VK_IMAGE_LAYOUT_GENERAL};
  VkWriteDescriptorSet writes[2] = {{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET},
                                    {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET}};
  writes[0].dstSet = writes[1].dstSet = set.get();
  writes[0].dstBinding = FIRE3DV_BINDING_FILTER_IN;
  writes[1].dstBinding = FIRE3DV_BINDING_FILTER_OUT;
  writes[0].descriptorCount = writes[1].descriptorCount = 1;
  writes[0].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  writes[1].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  writes[0].pImageInfo = &in_info;
  writes[1].pImageInfo = &out_info;
  vkUpdateDescriptorSets(device_.handle(), 2, writes, 0, nullptr);
  return set;
}

void ImageFilter::record(gpu::Recorder& recorder, const char* name, const Images& images, const void* push,
                         uint32_t push_bytes, gpu::Buffer* also_written, VkExtent2D part) {
  const bool all = part.width == 0;
  if (all) part = images.out.extent;
  std::vector<Use> uses{Use(images.in, access::compute_sample), Use(images.out, access::compute_write, all)};
  if (also_written) uses.emplace_back(*also_written, access::compute_write);
  recorder.pass(name, uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, &images.set.get(),
                            0, nullptr);
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, push_bytes, push);
    vkCmdDispatch(commands, (part.width + 7) / 8, (part.height + 7) / 8, 1);
  });
}

}  // namespace fire3dv::passes
