#include "renderer/passes/environment/environment_steps.h"

#include <algorithm>
#include <array>

#include "renderer/gpu/pipelines/descriptors.h"
#include "shaders/shared/bindings.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr uint32_t kMaxSteps = 48;  // two cubes of at most ten levels, and single steps

}  // namespace

EnvironmentSteps::EnvironmentSteps(gpu::Device& device, gpu::LoaderCommands& loader)
    : device_(device), loader_(loader) {
  constexpr VkShaderStageFlags kStage = VK_SHADER_STAGE_COMPUTE_BIT;
  const VkDescriptorSetLayoutBinding bindings[] = {
      {FIRE3DV_BINDING_LEVEL_IN, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, kStage, nullptr},
      {FIRE3DV_BINDING_LEVEL_OUT, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, kStage, nullptr},
      {FIRE3DV_BINDING_LEVEL_ABOVE, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, kStage, nullptr},
  };
  set_layout_ = gpu::create_set_layout(device, bindings);
  layout_ = gpu::create_pipeline_layout(device, std::array{set_layout_.get()});

  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kMaxSteps},
                                        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 2 * kMaxSteps}};
  pool_ = gpu::create_descriptor_pool(device, kMaxSteps, sizes);
}

void EnvironmentSteps::sample(std::string_view shader, gpu::Image& in, VkSampler sampler, gpu::Image& out,
                              uint32_t level, gpu_types::EnvironmentPush push) {
  step(shader, {&in, sampler, 0}, out, level, push);
}

void EnvironmentSteps::load(std::string_view shader, gpu::Image& in, uint32_t in_level, gpu::Image& out,
                            uint32_t level, gpu_types::EnvironmentPush push) {
  step(shader, {&in, VK_NULL_HANDLE, in_level}, out, level, push);
}

void EnvironmentSteps::fill(std::string_view shader, gpu::Image& out, gpu_types::EnvironmentPush push) {
  step(shader, {}, out, 0, push);
}

void EnvironmentSteps::step(std::string_view shader, const Input& in, gpu::Image& out, uint32_t level,
                            gpu_types::EnvironmentPush push) {
  auto known = std::find_if(pipelines_.begin(), pipelines_.end(),
                            [&](const auto& entry) { return entry.first == shader; });
  if (known == pipelines_.end()) {
    pipelines_.emplace_back(shader, gpu::create_compute_pipeline(device_, layout_.get(), shader));
    known = pipelines_.end() - 1;
  }

  const VkDescriptorSet set = gpu::allocate_set(device_, pool_.get(), set_layout_.get());

  std::vector<Use> uses;
  std::array<VkDescriptorImageInfo, 2> images{};
  std::array<VkWriteDescriptorSet, 2> writes{};
  views_.push_back(gpu::create_level_view(device_, out, level));
  images[0] = {VK_NULL_HANDLE, views_.back().get(), VK_IMAGE_LAYOUT_GENERAL};
  writes[0] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  writes[0].dstBinding = FIRE3DV_BINDING_LEVEL_OUT;
  writes[0].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  uses.emplace_back(out, access::compute_write);
  if (in.image) {
    writes[1] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    if (in.sampler) {
      images[1] = {in.sampler, in.image->view.get(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      writes[1].dstBinding = FIRE3DV_BINDING_LEVEL_IN;
      writes[1].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
      uses.emplace_back(*in.image, access::compute_sample);
    } else {
      views_.push_back(gpu::create_level_view(device_, *in.image, in.level));
      images[1] = {VK_NULL_HANDLE, views_.back().get(), VK_IMAGE_LAYOUT_GENERAL};
      writes[1].dstBinding = FIRE3DV_BINDING_LEVEL_ABOVE;
      writes[1].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
      if (in.image != &out) uses.emplace_back(*in.image, access::compute_read);
    }
  }
  const uint32_t write_count = in.image ? 2 : 1;
  for (uint32_t i = 0; i < write_count; ++i) {
    writes[i].dstSet = set;
    writes[i].descriptorCount = 1;
    writes[i].pImageInfo = &images[i];
  }
  vkUpdateDescriptorSets(device_.handle(), write_count, writes.data(), 0, nullptr);

  push.size = std::max(out.extent.width >> level, 1u);
  loader_.recorder().pass("environment", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, known->second.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, &set, 0, nullptr);
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (push.size + 7) / 8, (push.size + 7) / 8, out.layers);
  });
}

}  // namespace fire3dv::passes
