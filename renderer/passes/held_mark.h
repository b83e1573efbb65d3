// Marks a finished image as held: the stream that it shows sends no frames.
#pragma once

#include "renderer/gpu/descriptors.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/state/liveness.h"

namespace fire3dv::passes {

class HeldMark {
 public:
  explicit HeldMark(gpu::Device& device);

  void bind(const gpu::Image& image);  // after each change of size
  // Nothing where the condition is live.
  void record(gpu::Recorder& recorder, gpu::Image& image, state::Condition condition);

 private:
  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::DescriptorSet set_;
};

}  // namespace fire3dv::passes
