// Light meter: the exposure that brings the log-average luminance of an image to middle grey, from a
// histogram without its ends. It depends on this image alone.
#pragma once

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/resources/targets.h"

namespace fire3dv::passes {

class LightMeterPass {
 public:
  // samples: of the HDR target. is_path_traced: the light comes from path-traced sums instead.
  LightMeterPass(gpu::Device& device, VkSampleCountFlagBits samples, bool is_path_traced);

  void bind(Targets& targets) const;  // no effect on targets that are bound
  // Meters an image. fallback: exposure of images without scene-referred light. sums: of a path-traced image.
  // The result is valid until the next call.
  MeteredExposure record(gpu::Recorder& recorder, Targets& targets, float fallback, gpu::Buffer* sums);

 private:
  gpu::Device& device_;
  bool is_path_traced_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline histogram_pipeline_, resolve_pipeline_;
  gpu::Sampler sampler_;
  gpu::Buffer histogram_, exposure_;
};

}  // namespace fire3dv::passes
