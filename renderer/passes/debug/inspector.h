// Executes an Inspection on an image; see inspection.h. Pipelines are created on first use.
#pragma once

#include <memory>

#include "renderer/passes/debug/debug_views.h"
#include "renderer/passes/debug/pick_pass.h"

namespace fire3dv::passes {

class Inspector {
 public:
  // layout: with the scene's set only. samples: 1 or 4.
  Inspector(gpu::Device& device, VkPipelineLayout layout, VkDescriptorSetLayout scene_set_layout,
            uint32_t samples);

  // Selects the target image of the following calls.
  void draw_on(Targets& targets, const gpu::Image& image) { overlay_.draw_on(targets, image); }
  void pick(gpu::Recorder& recorder, const InspectedView& seen, const Pick& pick);
  // Null until the first pick.
  PickPass* picks() { return pick_.get(); }
  DebugViews& debug_views();
  // Outlines a node and its descendants on the finished image.
  void outline(gpu::Recorder& recorder, gpu::StagingRing& staging, const InspectedView& seen,
               uint32_t selected, gpu::Image& image);

 private:
  gpu::Device& device_;
  VkPipelineLayout layout_;
  uint32_t samples_;
  ImageOverlay overlay_;
  gpu::Pipeline outline_;
  std::unique_ptr<DebugViews> debug_views_;
  std::unique_ptr<PickPass> pick_;
};

}  // namespace fire3dv::passes
