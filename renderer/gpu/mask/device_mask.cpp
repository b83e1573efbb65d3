#include "renderer/gpu/mask/device_mask.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdlib>
#include <system_error>

#include "base/text.h"

namespace fire3dv::gpu {
namespace {

struct Flag {
  const char* word;
  bool DeviceMask::*member;
};
constexpr Flag kFlags[] = {{"no-ray-query", &DeviceMask::no_ray_query},
                           {"no-ray-pipeline", &DeviceMask::no_ray_pipeline},
                           {"no-int64-atomics", &DeviceMask::no_int64_atomics},
                           {"no-async-queue", &DeviceMask::no_async_queue},
                           {"no-anisotropy", &DeviceMask::no_anisotropy},
                           {"no-dual-source", &DeviceMask::no_dual_source},
                           {"no-sample-shading", &DeviceMask::no_sample_shading},
                           {"no-multisample-storage", &DeviceMask::no_multisample_storage},
                           {"no-visible-coverage", &DeviceMask::no_visible_coverage},
                           {"no-indirect-count", &DeviceMask::no_indirect_count},
                           {"no-scalar-layout", &DeviceMask::no_scalar_layout},
                           {"no-subgroup-operations", &DeviceMask::no_subgroup_operations},
                           {"no-software", &DeviceMask::no_software}};
struct Number {
  const char* word;
  uint32_t DeviceMask::*member;
  bool is_power_of_two;  // no device has another value
};
constexpr Number kNumbers[] = {{"samples", &DeviceMask::samples, true},
                               {"subgroup", &DeviceMask::subgroup, true},
                               {"threads", &DeviceMask::threads, false},
                               {"image-side", &DeviceMask::image_side, false}};

enum class Word { known, unknown, no_power_of_two };

Word set_word(DeviceMask& mask, std::string_view word) {
  for (const Flag& flag : kFlags) {
    if (word != flag.word) continue;
    mask.*flag.member = true;
    return Word::known;
  }
  const size_t equals = std::min(word.find('='), word.size());
  for (const Number& number : kNumbers) {
    if (word.substr(0, equals) != number.word || equals == word.size()) continue;
    const char* const end = word.data() + word.size();
    uint32_t& value = mask.*number.member;
    const auto [stop, result] = std::from_chars(word.data() + equals + 1, end, value);
    if (result != std::errc() || stop != end || value == 0) return Word::unknown;
    return number.is_power_of_two && !std::has_single_bit(value) ? Word::no_power_of_two : Word::known;
  }
  return Word::unknown;
}

}  // namespace

bool DeviceMask::hides_extension(std::string_view name) const {
  return (no_ray_query && name == VK_KHR_RAY_QUERY_EXTENSION_NAME) ||
         (no_ray_pipeline && name == VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME) ||
         (no_visible_coverage && name == VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME);
}

void DeviceMask::apply(VkPhysicalDeviceFeatures& core, VkPhysicalDeviceVulkan12Features& vulkan12) const {
  if (no_int64_atomics) vulkan12.shaderBufferInt64Atomics = VK_FALSE;
  if (no_indirect_count) vulkan12.drawIndirectCount = VK_FALSE;
  if (no_scalar_layout) vulkan12.scalarBlockLayout = VK_FALSE;
  if (no_anisotropy) core.samplerAnisotropy = VK_FALSE;
  if (no_dual_source) core.dualSrcBlend = VK_FALSE;
  if (no_sample_shading) core.sampleRateShading = VK_FALSE;
  if (no_multisample_storage) core.shaderStorageImageMultisample = VK_FALSE;
}

void DeviceMask::apply(VkPhysicalDeviceLimits& limits) const {
  if (samples > 0) {
    // Counts are bits of their own values: all up to `samples`.
    limits.framebufferColorSampleCounts &= 2 * samples - 1;
    limits.framebufferDepthSampleCounts &= 2 * samples - 1;
  }
  if (threads > 0) {
    limits.maxComputeWorkGroupInvocations = std::min(limits.maxComputeWorkGroupInvocations, threads);
    limits.maxComputeWorkGroupSize[0] = std::min(limits.maxComputeWorkGroupSize[0], threads);
  }
  if (image_side > 0) limits.maxImageDimension2D = std::min(limits.maxImageDimension2D, image_side);
}

void DeviceMask::apply(VkPhysicalDeviceVulkan11Properties& properties) const {
  if (subgroup > 0) properties.subgroupSize = subgroup;
  if (no_subgroup_operations) properties.subgroupSupportedOperations = VK_SUBGROUP_FEATURE_BASIC_BIT;
}

void DeviceMask::apply(std::vector<VkQueueFamilyProperties>& families) const {
  if (!no_async_queue) return;
  for (VkQueueFamilyProperties& family : families) {
    family.queueCount = std::min(family.queueCount, 1u);
    if (!(family.queueFlags & VK_QUEUE_GRAPHICS_BIT))
      family.queueFlags &= ~VkQueueFlags{VK_QUEUE_COMPUTE_BIT};
  }
}

Result<DeviceMask> parse_device_mask(std::string_view text) {
  DeviceMask mask;
  mask.text = text;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    const Word known = set_word(mask, word);
    if (known == Word::no_power_of_two)
      return Error{"FIRE3DV_DEVICE_MASK: " + quote(word) + " is no power of two, as all devices have"};
    if (known == Word::unknown) {
      std::string words;
      for (const Flag& flag : kFlags) words += std::string(" ") + flag.word;
      for (const Number& number : kNumbers) words += std::string(" ") + number.word + "=N";
      return Error{"FIRE3DV_DEVICE_MASK: unknown word " + quote(word) + "; the words are:" + words};
    }
    begin = end + 1;
  }
  return mask;
}

const Result<DeviceMask>& environment_mask() {
  static const Result<DeviceMask> mask = [] {
    const char* const value = std::getenv("FIRE3DV_DEVICE_MASK");
    return parse_device_mask(value ? value : "");
  }();
  return mask;
}

const DeviceMask& device_mask() {
  static const DeviceMask none;
  const Result<DeviceMask>& mask = environment_mask();
  return mask ? *mask : none;
}

}  // namespace fire3dv::gpu
