// Post-processing of the HDR target: exposure, tone mapping, resolve, sRGB encoding, then FXAA.
#pragma once

#include "renderer/passes/post/image_filter.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view.h"

namespace fire3dv::passes {

enum class ToneMap { reinhard, aces, neutral, none };

uint32_t tone_map_number(ToneMap tone_map);  // FIRE3DV_TONE_MAP_*

struct PostSettings {
  float exposure = 1;
  ToneMap tone_map = ToneMap::reinhard;
  bool fxaa = true;
};

inline float exposure_of(const View& view, const PostSettings& settings) {
  return view.exposure > 0 ? view.exposure : settings.exposure;
}

class PostPass {
 public:
  PostPass(gpu::Device& device, VkSampleCountFlagBits samples);

  void bind(Targets& targets) const;  // call once; for one view
  // Buffer and address of wire::kColorLinearF16, if requested.
  struct Linear {
    gpu::Buffer* buffer = nullptr;
    VkDeviceAddress address = 0;
  };
  // part: pixels that still need tone mapping; the others are complete.
  void record(gpu::Recorder& recorder, Targets& targets, const PostSettings& settings, const Linear& linear,
              const VkRect2D& part);
  // FXAA only, for an image that is already tone-mapped.
  void smooth(gpu::Recorder& recorder, Targets& targets, const PostSettings& settings);
  // Image with the result of record() under these settings.
  static gpu::Image& result(Targets& targets, const PostSettings& settings) {
    return settings.fxaa ? targets.smoothed : targets.display;
  }

 private:
  ImageFilter tone_map_, fxaa_;
};

}  // namespace fire3dv::passes
