#include "renderer/passes/post/post_pass.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "renderer/gpu/device/image_array.h"

#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

using gpu::Use;
namespace access = gpu::access;

ImageFilter::ImageFilter(gpu::Device& device, std::string_view shader, VkFilter sampling) : device_(device) {
  const VkDescriptorSetLayoutBinding bindings[] = {
      {FIRE3DV_BINDING_FILTER_IN, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_COMPUTE_BIT,
       nullptr},
      {FIRE3DV_BINDING_FILTER_OUT, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
      {FIRE3DV_BINDING_FILTER_BLOOM, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
       VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
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

gpu::DescriptorSet ImageFilter::bind(const gpu::Image* in, const gpu::Image& out,
                                     const gpu::Image* bloom) const {
  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2},
                                        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1}};
  gpu::DescriptorSet set(device_, set_layout_.get(), sizes);
  const auto write = [&](uint32_t binding, VkDescriptorType type, const VkDescriptorImageInfo& info) {
    VkWriteDescriptorSet value{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    value.dstSet = set.get();
    value.dstBinding = binding;
    value.descriptorCount = 1;
    value.descriptorType = type;
    value.pImageInfo = &info;
    vkUpdateDescriptorSets(device_.handle(), 1, &value, 0, nullptr);
  };
  const auto write_sampled = [&](uint32_t binding, const gpu::Image* image) {
    if (image)
      write(binding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
            {sampler_.get(), image->view.get(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
  };
  write_sampled(FIRE3DV_BINDING_FILTER_IN, in);
  write_sampled(FIRE3DV_BINDING_FILTER_BLOOM, bloom);
  write(FIRE3DV_BINDING_FILTER_OUT, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE,
        {VK_NULL_HANDLE, out.view.get(), VK_IMAGE_LAYOUT_GENERAL});
  return set;
}

void ImageFilter::record(gpu::Recorder& recorder, const char* name, const Images& images, const void* push,
                         uint32_t push_bytes, std::span<const Use> buffers, VkExtent2D part,
                         uint32_t layers) {
  const bool all = part.width == 0;
  if (all) part = images.out.extent;
  std::vector<Use> uses(buffers.begin(), buffers.end());
  for (gpu::Image* const read : {images.in, images.bloom}) {
    if (read) uses.emplace_back(*read, access::compute_sample);
  }
  uses.emplace_back(images.out, access::compute_write, all);
  recorder.pass(name, uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, &images.set.get(),
                            0, nullptr);
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, push_bytes, push);
    vkCmdDispatch(commands, (part.width + 7) / 8, (part.height + 7) / 8, layers);
  });
}

namespace {

uint32_t curve_number(settings::ToneMap tone_map) {
  switch (tone_map) {
    case settings::ToneMap::reinhard:
      return FIRE3DV_TONE_MAP_REINHARD;
    case settings::ToneMap::aces:
      return FIRE3DV_TONE_MAP_ACES;
    case settings::ToneMap::neutral:
      return FIRE3DV_TONE_MAP_NEUTRAL;
    case settings::ToneMap::none:
      return FIRE3DV_TONE_MAP_NONE;
  }
  return FIRE3DV_TONE_MAP_NONE;
}

}  // namespace

// Layout: see display_linear() in tone_map.glsl.
uint32_t tone_map_number(const settings::PostSettings& settings) {
  const auto saturation = static_cast<uint32_t>(std::lround(settings.saturation * 1024));
  return curve_number(settings.tone_map) | (saturation == 1024 ? 0 : (saturation + 1) << 8);
}

PostPass::PostPass(gpu::Device& device, VkSampleCountFlagBits samples)
    : samples_(samples),
      tone_map_(device, samples == VK_SAMPLE_COUNT_1_BIT ? "post.comp" : "post_multisampled.comp",
                VK_FILTER_NEAREST),
      fxaa_(device, "fxaa.comp", VK_FILTER_LINEAR) {}

void PostPass::bind(Targets& targets) const {
  targets.tone_map_set = tone_map_.bind(&targets.hdr, targets.display);
  targets.fxaa_set = fxaa_.bind(&targets.display, targets.smoothed);
}

void PostPass::bind_bloom(gpu::Device& device, Targets& targets) {
  if (!tone_map_bloom_)
    tone_map_bloom_ = std::make_unique<ImageFilter>(
        device, samples_ == VK_SAMPLE_COUNT_1_BIT ? "post_bloom.comp" : "post_bloom_multisampled.comp",
        VK_FILTER_NEAREST);
  targets.bloom->tone_map_set =
      tone_map_bloom_->bind(&targets.hdr, targets.display, &targets.bloom->levels.front());
}

void PostPass::record(gpu::Recorder& recorder, Targets& targets, const settings::PostSettings& settings,
                      const Linear& linear, const MeteredExposure& metered, const VkRect2D& part) {
  if (part.extent.width == 0 && !linear.buffer) return smooth(recorder, targets, settings);
  gpu_types::PostPush push{};
  push.linear = linear.address;
  push.metered = metered.address;
  push.first_x = static_cast<uint32_t>(part.offset.x);
  push.first_y = static_cast<uint32_t>(part.offset.y);
  push.end_x = push.first_x + part.extent.width;
  push.end_y = push.first_y + part.extent.height;
  push.width = targets.extent.width;
  push.height = targets.extent.height;
  push.samples = targets.samples;
  push.exposure = settings.exposure;
  push.tone_map = tone_map_number(settings);
  push.bloom = settings.bloom;
  std::vector<Use> buffers;
  if (linear.buffer) buffers.emplace_back(*linear.buffer, access::compute_write);
  if (metered.buffer) buffers.emplace_back(*metered.buffer, access::compute_read);
  const bool is_whole =
      part.extent.width == targets.extent.width && part.extent.height == targets.extent.height;
  VkExtent2D processed = part.extent;
  if (is_whole) {
    processed = {};
  } else if (linear.buffer) {
    processed = targets.extent;
  }
  if (settings.bloom > 0) {
    BloomImages& bloom = *targets.bloom;
    tone_map_bloom_->record(recorder, "post",
                            {&targets.hdr, targets.display, bloom.tone_map_set, &bloom.levels.front()}, push,
                            buffers, processed);
  } else {
    tone_map_.record(recorder, "post", {&targets.hdr, targets.display, targets.tone_map_set}, push, buffers,
                     processed);
  }
  smooth(recorder, targets, settings);
}

void PostPass::bind_layers(gpu::Device& device, Targets& targets) {
  if (targets.layers) return;
  const VkFormat format = targets.display.format;
  gpu::Image smoothed = gpu::create_image(
      device, {format, targets.display.extent,
               VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
  gpu::Image layers = gpu::create_image_array(
      device, {format, targets.extent, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT},
      targets.views);
  if (!fxaa_layers_)
    fxaa_layers_ = std::make_unique<ImageFilter>(device, "fxaa_layers.comp", VK_FILTER_LINEAR);
  targets.fxaa_set = fxaa_layers_->bind(&layers, smoothed);
  targets.smoothed = std::move(smoothed);
  targets.layers = std::move(layers);
}

// Taps of a view must not reach its neighbours in the stack, and must have the coordinates of an image alone.
void PostPass::smooth_layers(gpu::Recorder& recorder, Targets& targets) {
  const auto [width, height] = targets.extent;
  std::vector<VkImageCopy> regions;
  for (uint32_t view = 0; view < targets.views; ++view)
    regions.push_back({{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                       {0, static_cast<int32_t>(view * height), 0},
                       {VK_IMAGE_ASPECT_COLOR_BIT, 0, view, 1},
                       {0, 0, 0},
                       {width, height, 1}});
  recorder.pass(
      "fxaa",
      {Use(targets.display, access::transfer_read), Use(targets.layers, access::transfer_write, true)},
      [&](VkCommandBuffer commands) {
        vkCmdCopyImage(commands, targets.display.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                       targets.layers.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                       static_cast<uint32_t>(regions.size()), regions.data());
      });
  const gpu_types::FxaaPush fxaa_push{width, height};
  fxaa_layers_->record(recorder, "fxaa", {&targets.layers, targets.smoothed, targets.fxaa_set}, fxaa_push, {},
                       targets.extent, targets.views);
}

void PostPass::smooth(gpu::Recorder& recorder, Targets& targets, const settings::PostSettings& settings) {
  if (!settings.fxaa) return;
  if (targets.views > 1) return smooth_layers(recorder, targets);
  const gpu_types::FxaaPush fxaa_push{targets.extent.width, targets.extent.height};
  fxaa_.record(recorder, "fxaa", {&targets.display, targets.smoothed, targets.fxaa_set}, fxaa_push);
}

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
  recorder.pass("stale overlay", {gpu::Use(image, gpu::access::compute_write)},
                [&](VkCommandBuffer commands) {
                  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
                  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1,
                                          &targets.stale_overlay_set.get(), 0, nullptr);
                  vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof push, &push);
                  vkCmdDispatch(commands, (image.extent.width + 7) / 8, (image.extent.height + 7) / 8, 1);
                });
}

}  // namespace fire3dv::passes
