// Post-processing of colours: exposure, tone mapping, resolve and sRGB encoding of the HDR target, FXAA, and
// the stale overlay on finished images.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view/view.h"
#include "renderer/settings/post_settings.h"
#include "renderer/state/stream_timing.h"

namespace fire3dv::passes {

// Compute filter that writes an image: tone mapping, anti-aliasing, bloom.
class ImageFilter {
 public:
  // The shader reads FIRE3DV_BINDING_FILTER_IN and FIRE3DV_BINDING_FILTER_BLOOM, if it has them, through a
  // sampler (linear or nearest) and writes FIRE3DV_BINDING_FILTER_OUT.
  ImageFilter(gpu::Device& device, std::string_view shader, VkFilter sampling);

  // Sources (null: the shader has no such binding) and target with their descriptor set.
  struct Images {
    gpu::Image* in;
    gpu::Image& out;
    const gpu::DescriptorSet& set;
    gpu::Image* bloom = nullptr;
  };
  gpu::DescriptorSet bind(const gpu::Image* in, const gpu::Image& out,
                          const gpu::Image* bloom = nullptr) const;

  // buffers: those that the push constants refer to. part: size of the processed area, from the corner that
  // the push constants name; the rest of `out` stays. Empty: the whole image. layers: of the source; each of
  // them has `part`.
  template <typename Push>
  void record(gpu::Recorder& recorder, const char* name, const Images& images, const Push& push,
              std::span<const gpu::Use> buffers = {}, VkExtent2D part = {0, 0}, uint32_t layers = 1) {
    static_assert(sizeof(Push) <= gpu::kPushConstantBytes);
    record(recorder, name, images, &push, sizeof(Push), buffers, part, layers);
  }

 private:
  void record(gpu::Recorder& recorder, const char* name, const Images& images, const void* push,
              uint32_t push_bytes, std::span<const gpu::Use> buffers, VkExtent2D part, uint32_t layers);

  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Sampler sampler_;
};

uint32_t tone_map_number(const settings::PostSettings& settings);  // FIRE3DV_TONE_MAP_*

inline float exposure_of(const View& view, const settings::PostSettings& settings) {
  return view.exposure > 0 ? view.exposure : settings.exposure;
}

// Exposure that LightMeterPass has written for an image. Null: the exposure of the settings.
struct MeteredExposure {
  gpu::Buffer* buffer = nullptr;
  VkDeviceAddress address = 0;  // of a float
};

class PostPass {
 public:
  PostPass(gpu::Device& device, VkSampleCountFlagBits samples);

  void bind(Targets& targets) const;  // call once; for one view
  // Buffer and address of wire::kColorLinearF16, if requested.
  struct Linear {
    gpu::Buffer* buffer = nullptr;
    VkDeviceAddress address = 0;
  };
  // Creates the variant with bloom, and binds it to targets with a bloom chain.
  void bind_bloom(gpu::Device& device, Targets& targets);
  // Creates the images of several views that FXAA needs, unless the targets have them.
  void bind_layers(gpu::Device& device, Targets& targets);
  // part: pixels that still need tone mapping; the others are complete. The linear plane has all pixels. With
  // bloom, targets.bloom has the light of this image.
  void record(gpu::Recorder& recorder, Targets& targets, const settings::PostSettings& settings,
              const Linear& linear, const MeteredExposure& metered, const VkRect2D& part);
  // FXAA only, for an image that is already tone-mapped.
  void smooth(gpu::Recorder& recorder, Targets& targets, const settings::PostSettings& settings);
  // Image with the result of record() or smooth() under these settings.
  static gpu::Image& result(Targets& targets, const settings::PostSettings& settings) {
    return settings.fxaa && targets.smoothed ? targets.smoothed : targets.display;
  }

 private:
  void smooth_layers(gpu::Recorder& recorder, Targets& targets);

  VkSampleCountFlagBits samples_;
  ImageFilter tone_map_, fxaa_;
  std::unique_ptr<ImageFilter> tone_map_bloom_, fxaa_layers_;  // created on first use
};

// Stale overlay: marks a finished image whose stream sends no frames.
class StaleOverlayPass {
 public:
  explicit StaleOverlayPass(gpu::Device& device);

  // image: of the targets. Draws nothing where the condition is live.
  void record(gpu::Recorder& recorder, Targets& targets, gpu::Image& image, state::Condition condition);

 private:
  void bind(Targets& targets, const gpu::Image& image) const;

  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
};

}  // namespace fire3dv::passes
