#include "renderer/passes/post/light_meter_pass.h"

#include <array>
#include <vector>

#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr uint32_t kMeterTileSide = 64;  // pixels of a workgroup
constexpr VkDeviceSize kHistogramBytes = FIRE3DV_METER_BINS * sizeof(uint32_t);
static_assert(FIRE3DV_METER_BINS % 256 == 0, "each lane of light_meter_resolve.comp has the same number");

const char* histogram_shader(VkSampleCountFlagBits samples, bool is_path_traced) {
  if (is_path_traced) return "light_meter_path.comp";
  return samples == VK_SAMPLE_COUNT_1_BIT ? "light_meter.comp" : "light_meter_multisampled.comp";
}

}  // namespace

LightMeterPass::LightMeterPass(gpu::Device& device, VkSampleCountFlagBits samples, bool is_path_traced)
    : device_(device), is_path_traced_(is_path_traced) {
  const VkDescriptorSetLayoutBinding binding{FIRE3DV_BINDING_FILTER_IN,
                                             VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
                                             VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  set_layout_ = gpu::create_set_layout(device, {&binding, 1});
  layout_ = gpu::create_pipeline_layout(device, std::array{set_layout_.get()});
  histogram_pipeline_ =
      gpu::create_compute_pipeline(device, layout_.get(), histogram_shader(samples, is_path_traced));
  resolve_pipeline_ = gpu::create_compute_pipeline(device, layout_.get(), "light_meter_resolve.comp");
  const VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  VkSampler sampler = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSampler(device.handle(), &info, nullptr, &sampler));
  sampler_ = gpu::Sampler(device, sampler);
  histogram_ =
      gpu::create_buffer(device, kHistogramBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
  exposure_ =
      gpu::create_buffer(device, sizeof(float), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

void LightMeterPass::bind(Targets& targets) const {
  if (is_path_traced_ || targets.light_meter_set.get() != VK_NULL_HANDLE) return;
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
  targets.light_meter_set = gpu::DescriptorSet(device_, set_layout_.get(), {&size, 1});
  const VkDescriptorImageInfo info{sampler_.get(), targets.hdr.view.get(),
                                   VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = targets.light_meter_set.get();
  write.dstBinding = FIRE3DV_BINDING_FILTER_IN;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  write.pImageInfo = &info;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

MeteredExposure LightMeterPass::record(gpu::Recorder& recorder, Targets& targets, float fallback,
                                       gpu::Buffer* sums) {
  recorder.pass(
      "light meter clear", {Use(histogram_, access::transfer_write)},
      [&](VkCommandBuffer commands) { vkCmdFillBuffer(commands, histogram_.get(), 0, kHistogramBytes, 0); });
  gpu_types::LightMeterPush push{};
  push.histogram = histogram_.address;
  push.width = targets.extent.width;
  push.height = targets.extent.height;
  push.samples = static_cast<uint32_t>(targets.samples);
  std::vector<Use> uses{Use(histogram_, access::compute_write)};
  if (sums) {
    push.sums = sums->address;
    uses.emplace_back(*sums, access::compute_read);
  } else {
    uses.emplace_back(targets.hdr, access::compute_sample);
  }
  recorder.pass("light meter", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, histogram_pipeline_.get());
    if (!sums)
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1,
                              &targets.light_meter_set.get(), 0, nullptr);
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (push.width + kMeterTileSide - 1) / kMeterTileSide,
                  (push.height + kMeterTileSide - 1) / kMeterTileSide, 1);
  });
  const gpu_types::LightMeterResolvePush resolve{histogram_.address, exposure_.address, fallback};
  recorder.pass(
      "light meter resolve", {Use(histogram_, access::compute_read), Use(exposure_, access::compute_write)},
      [&](VkCommandBuffer commands) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, resolve_pipeline_.get());
        vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(resolve), &resolve);
        vkCmdDispatch(commands, 1, 1, 1);
      });
  return {&exposure_, exposure_.address};
}

}  // namespace fire3dv::passes
