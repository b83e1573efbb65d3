// Does what an Inspection wants of an image; see inspection.h. Whatever is not wanted has no pipeline.
#pragma once

#include <memory>

#include "renderer/passes/debug_views.h"
#include "renderer/passes/pick_pass.h"

namespace fire3dv::passes {

class Inspector {
 public:
  // layout: of the scene's set alone. samples: 1 or 4.
  Inspector(gpu::Device& device, VkPipelineLayout layout, VkDescriptorSetLayout scene_set_layout,
            uint32_t samples);

  // What follows is over this image of the targets.
  void draw_on(Targets& targets, const gpu::Image& image) { overlay_.draw_on(targets, image); }
  void pick(gpu::Recorder& recorder, const SeenView& seen, const Pick& pick);
  // Null until something was picked.
  PickPass* picks() { return pick_.get(); }
  DebugViews& debug_views();
  // Around what the finished image shows of a node and all below it.
  void outline(gpu::Recorder& recorder, gpu::UploadBelt& belt, const SeenView& seen, uint32_t selected,
               gpu::Image& image);

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
