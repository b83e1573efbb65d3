#include "renderer/passes/post/bloom_pass.h"

#include <algorithm>
#include <bit>
#include <utility>
#include <vector>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Each level is as strong as this share of the one above. With levels of a quarter of the density, light
// falls off with the distance to the power of -2.5, between the glare of lenses and of the eye (Spencer et
// al. 1995).
constexpr float kShareOfLevelBelow = 0.7f;
constexpr uint32_t kMaxLevels = 8;

const char* light_shader(VkSampleCountFlagBits samples, bool is_path_traced) {
  if (is_path_traced) return "bloom_light_path.comp";
  return samples == VK_SAMPLE_COUNT_1_BIT ? "bloom_light.comp" : "bloom_light_multisampled.comp";
}

}  // namespace

uint32_t bloom_levels(VkExtent2D extent) {
  const auto doublings = static_cast<int>(std::bit_width(std::min(extent.width, extent.height))) - 1;
  return static_cast<uint32_t>(std::clamp(doublings - 2, 1, static_cast<int>(kMaxLevels)));
}

BloomPass::BloomPass(gpu::Device& device, VkSampleCountFlagBits samples, bool is_path_traced)
    : device_(device),
      is_path_traced_(is_path_traced),
      light_(device, light_shader(samples, is_path_traced), VK_FILTER_NEAREST),
      down_(device, "bloom_down.comp", VK_FILTER_NEAREST),
      up_(device, "bloom_up.comp", VK_FILTER_NEAREST) {}

bool BloomPass::allocate(Targets& targets) const {
  if (targets.bloom) return false;
  BloomImages bloom;
  gpu::ImageInfo info{VK_FORMAT_R16G16B16A16_SFLOAT, targets.extent,
                      VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, 1};
  bloom.light = gpu::create_image(device_, info);
  const uint32_t count = bloom_levels(targets.extent);
  for (uint32_t level = 0; level < count; ++level) {
    info.extent = {(info.extent.width + 1) / 2, (info.extent.height + 1) / 2};
    bloom.levels.push_back(gpu::create_image(device_, info));
  }
  bloom.light_set = light_.bind(is_path_traced_ ? nullptr : &targets.hdr, bloom.light);
  for (uint32_t level = 0; level < count; ++level) {
    const gpu::Image& above = level == 0 ? bloom.light : bloom.levels[level - 1];
    bloom.down_sets.push_back(down_.bind(&above, bloom.levels[level]));
    if (level + 1 < count) bloom.up_sets.push_back(up_.bind(&bloom.levels[level + 1], bloom.levels[level]));
  }
  targets.bloom = std::move(bloom);
  return true;
}

void BloomPass::record(gpu::Recorder& recorder, Targets& targets, float exposure,
                       const MeteredExposure& metered, gpu::Buffer* sums) {
  BloomImages& bloom = *targets.bloom;
  gpu_types::BloomLightPush push{};
  push.width = targets.extent.width;
  push.height = targets.extent.height;
  push.samples = static_cast<uint32_t>(targets.samples);
  push.exposure = exposure;
  push.metered = metered.address;
  std::vector<Use> buffers;
  if (metered.buffer) buffers.emplace_back(*metered.buffer, access::compute_read);
  if (sums) {
    push.sums = sums->address;
    buffers.emplace_back(*sums, access::compute_read);
  }
  light_.record(recorder, "bloom light", {sums ? nullptr : &targets.hdr, bloom.light, bloom.light_set}, push,
                buffers);
  const auto count = static_cast<uint32_t>(bloom.levels.size());
  const gpu_types::BloomUpPush up_push{kShareOfLevelBelow};
  for (uint32_t level = 0; level < count; ++level) {
    gpu::Image& above = level == 0 ? bloom.light : bloom.levels[level - 1];
    down_.record(recorder, "bloom down", {&above, bloom.levels[level], bloom.down_sets[level]}, up_push);
  }
  for (uint32_t level = count - 1; level-- > 0;) {
    gpu::Image& image = bloom.levels[level];
    up_.record(recorder, "bloom up", {&bloom.levels[level + 1], image, bloom.up_sets[level]}, up_push, {},
               image.extent);
  }
}

}  // namespace fire3dv::passes
