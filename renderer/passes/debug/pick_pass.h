// Picking at a pixel. The result arrives through the readback ring frames later, with its tag.
#pragma once

#include <vector>

#include "renderer/passes/debug/inspection.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/passes/post/image_overlay.h"

namespace fire3dv::passes {

class PickPass {
 public:
  // samples: 1 or 4.
  PickPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples);

  // The pixel must lie in the image.
  void record(gpu::Recorder& recorder, const InspectedView& seen, const Pick& pick);
  void submitted(uint64_t timeline_value) { belt_.submitted(timeline_value); }
  // Returns new results, oldest first.
  std::vector<Picked> take_picked();

 private:
  VkPipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer picked_;  // PickedSurface
  gpu::ReadbackRing<uint64_t> belt_;
};

}  // namespace fire3dv::passes
