// Stale overlay: marks a finished image whose stream sends no frames.
#pragma once

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/state/liveness.h"

namespace fire3dv::passes {

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
