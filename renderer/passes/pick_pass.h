// What lies at a pixel. The answer comes through the read-back belt, frames later, with its tag.
#pragma once

#include <vector>

#include "renderer/passes/image_overlay.h"
#include "renderer/passes/inspection.h"
#include "renderer/passes/readback_belt.h"

namespace fire3dv::passes {

class PickPass {
 public:
  // samples: 1 or 4.
  PickPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples);

  // The pixel is in the image.
  void record(gpu::Recorder& recorder, const SeenView& seen, const Pick& pick);
  void submitted(uint64_t timeline_value) { belt_.submitted(timeline_value); }
  // What has been found since, oldest first.
  std::vector<Picked> take_picked();

 private:
  VkPipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer picked_;  // PickedSurface
  ReadbackBelt<uint64_t> belt_;
};

}  // namespace fire3dv::passes
