// From the HDR target to the image that leaves the renderer: exposure, tone mapping, resolve and sRGB
// encoding, then FXAA.
#pragma once

#include "renderer/passes/image_filter.h"
#include "renderer/passes/targets.h"
#include "renderer/passes/view.h"

namespace fire3dv::passes {

enum class ToneMap { reinhard, aces, neutral, none };

uint32_t tone_map_number(ToneMap tone_map);  // as the shaders have it

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

  void bind(Targets& targets) const;  // once, of one view
  // linear: Plane::color_linear_f16 at this address of the buffer, where it is wanted.
  struct Linear {
    gpu::Buffer* buffer = nullptr;
    VkDeviceAddress address = 0;
  };
  // part: what else there is of the image is tone-mapped already.
  void record(gpu::Recorder& recorder, Targets& targets, const PostSettings& settings, const Linear& linear,
              const VkRect2D& part);
  // FXAA alone, of an image that is tone-mapped already.
  void smooth(gpu::Recorder& recorder, Targets& targets, const PostSettings& settings);
  // The image that record() with these settings leaves its result in.
  static gpu::Image& result(Targets& targets, const PostSettings& settings) {
    return settings.fxaa ? targets.smoothed : targets.display;
  }

 private:
  ImageFilter tone_map_, fxaa_;
};

}  // namespace fire3dv::passes
