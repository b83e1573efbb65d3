// Marks a finished image as held: the stream that it shows sends no frames.
#pragma once

#include "renderer/gpu/descriptors.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/targets.h"
#include "renderer/state/liveness.h"

namespace fire3dv::passes {

class HeldMark {
 public:
  explicit HeldMark(gpu::Device& device);

  // image: of the targets. Nothing where the condition is live.
  void record(gpu::Recorder& recorder, Targets& targets, gpu::Image& image, state::Condition condition);

 private:
  void bind(Targets& targets, const gpu::Image& image) const;

  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
};

}  // namespace fire3dv::passes
