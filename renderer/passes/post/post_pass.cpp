#include "renderer/passes/post/post_pass.h"

#include "shaders/shared/types.h"

namespace fire3dv::passes {

uint32_t tone_map_number(ToneMap tone_map) {
  switch (tone_map) {
    case ToneMap::reinhard:
      return FIRE3DV_TONE_MAP_REINHARD;
    case ToneMap::aces:
      return FIRE3DV_TONE_MAP_ACES;
    case ToneMap::neutral:
      return FIRE3DV_TONE_MAP_NEUTRAL;
    case ToneMap::none:
      return FIRE3DV_TONE_MAP_NONE;
  }
  return FIRE3DV_TONE_MAP_NONE;
}

PostPass::PostPass(gpu::Device& device, VkSampleCountFlagBits samples)
    : tone_map_(device, samples == VK_SAMPLE_COUNT_1_BIT ? "post.comp" : "post_multisampled.comp",
                VK_FILTER_NEAREST),
      fxaa_(device, "fxaa.comp", VK_FILTER_LINEAR) {}

void PostPass::bind(Targets& targets) const {
  targets.tone_map_set = tone_map_.bind(targets.hdr, targets.display);
  targets.fxaa_set = fxaa_.bind(targets.display, targets.smoothed);
}

void PostPass::record(gpu::Recorder& recorder, Targets& targets, const PostSettings& settings,
                      const Linear& linear, const VkRect2D& part) {
  if (part.extent.width == 0) return smooth(recorder, targets, settings);
  const bool whole = part.extent.width == targets.extent.width && part.extent.height == targets.extent.height;
  gpu_types::PostPush push{};
  push.linear = linear.address;
  push.first_x = static_cast<uint32_t>(part.offset.x);
  push.first_y = static_cast<uint32_t>(part.offset.y);
  push.end_x = push.first_x + part.extent.width;
  push.end_y = push.first_y + part.extent.height;
  push.samples = targets.samples;
  push.exposure = settings.exposure;
  push.tone_map = tone_map_number(settings.tone_map);
  tone_map_.record(recorder, "post", {targets.hdr, targets.display, targets.tone_map_set}, push,
                   linear.buffer, whole ? VkExtent2D{0, 0} : part.extent);
  smooth(recorder, targets, settings);
}

void PostPass::smooth(gpu::Recorder& recorder, Targets& targets, const PostSettings& settings) {
  if (!settings.fxaa) return;
  const gpu_types::FxaaPush fxaa_push{targets.extent.width, targets.extent.height};
  fxaa_.record(recorder, "fxaa", {targets.display, targets.smoothed, targets.fxaa_set}, fxaa_push);
}

}  // namespace fire3dv::passes
