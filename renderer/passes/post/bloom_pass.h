// Bloom: scattered light of bright pixels, as in a lens (Jimenez 2014). A chain of halved images blurs the
// exposed light in linear colours; tone mapping then mixes it with the image, so that energy is conserved.
#pragma once

#include "renderer/gpu/recorder.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/resources/targets.h"

namespace fire3dv::passes {

// Number of levels of a chain: the deepest one has 4 to 8 texels along the image's shorter side, at most 8
// levels.
uint32_t bloom_levels(VkExtent2D extent);

class BloomPass {
 public:
  // samples: of the HDR target. is_path_traced: the light comes from path-traced sums instead.
  BloomPass(gpu::Device& device, VkSampleCountFlagBits samples, bool is_path_traced);

  // Creates the images of targets.bloom, unless they exist. Returns true if it did.
  bool allocate(Targets& targets) const;
  // Writes the blurred light of an image to the first level. sums: of a path-traced image.
  void record(gpu::Recorder& recorder, Targets& targets, float exposure, const MeteredExposure& metered,
              gpu::Buffer* sums);

 private:
  gpu::Device& device_;
  bool is_path_traced_;
  ImageFilter light_, down_, up_;
};

}  // namespace fire3dv::passes
