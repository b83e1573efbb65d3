// Exposure, tone mapping, resolve and sRGB encoding: from the HDR target to the image that leaves the renderer.
#pragma once

#include "renderer/gpu/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/targets.h"

namespace fire3dv::passes {

enum class ToneMap { reinhard, none };

struct PostSettings {
  float exposure = 1;
  ToneMap tone_map = ToneMap::reinhard;
};

class PostPass {
 public:
  PostPass(gpu::Device& device, VkSampleCountFlagBits samples);

  void bind(const Targets& targets);  // after each change of size
  void record(gpu::Recorder& recorder, Targets& targets, const PostSettings& settings);

 private:
  gpu::Device& device_;
  gpu::SetLayout scene_layout_, set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Sampler sampler_;
  gpu::DescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace fire3dv::passes
