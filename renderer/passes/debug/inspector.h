// Passes of an Inspection (inspection.h) on an image: picking, debug views and the outline of the selected
// node.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/passes/debug/inspection.h"
#include "renderer/passes/raster/cluster_raster.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/shadows/shadow_pass.h"
#include "renderer/passes/view/camera_levels.h"
#include "renderer/passes/view/view.h"

namespace fire3dv::passes {

// A camera view whose visibility buffer is complete.
struct InspectedView {
  const scene::Scene& scene;
  GpuScene& gpu_scene;
  gpu::Buffer& visibility;
  const View& view;
  VkDeviceAddress globals;
  VkExtent2D extent;
};

// Common bindings of passes that draw over a finished image: the image and the scene.
class ImageOverlay {
 public:
  ImageOverlay(gpu::Device& device, VkDescriptorSetLayout scene_set_layout);

  void draw_on(Targets& targets, const gpu::Image& image);
  VkPipelineLayout layout() const { return layout_.get(); }

  template <typename Push>
  void begin(VkCommandBuffer commands, const gpu::Pipeline& pipeline, const GpuScene& scene,
             const Push& push) const {
    static_assert(sizeof(Push) <= gpu::kPushConstantBytes);
    begin(commands, pipeline, scene, &push, sizeof(Push));
  }

 private:
  void begin(VkCommandBuffer commands, const gpu::Pipeline& pipeline, const GpuScene& scene, const void* push,
             uint32_t push_bytes) const;

  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;  // of the targets
};

// Picking at a pixel. The result arrives through the readback ring frames later, with its tag.
class PickPass {
 public:
  // samples: 1 or 4.
  PickPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples);

  // The pixel must lie in the image.
  void record(gpu::Recorder& recorder, const InspectedView& seen, const Pick& pick);
  void submitted(uint64_t timeline_value) { ring_.submitted(timeline_value); }
  // Returns new results, oldest first.
  std::vector<Picked> take_picked();

 private:
  VkPipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer picked_;  // PickedSurface
  struct Pending {
    uint64_t tag = 0;
    std::vector<uint32_t> nodes_of_parts;  // of the picked scene, which may be replaced meanwhile
    uint32_t node_count = 0;
  };
  gpu::ReadbackRing<Pending> ring_;
};

// See DebugView.
class DebugViews {
 public:
  // layout: of the raster shaders. samples: 1 or 4.
  DebugViews(gpu::Device& device, VkPipelineLayout layout, const ImageOverlay& overlay, uint32_t samples);

  // Draw settings for views that rasterise the scene again.
  struct Drawn {
    settings::Cull cull = settings::Cull::automatic;
    CameraLevels levels = CameraLevels::finest;
  };
  // Replaces the whole image. Call it before the coverage merge.
  void show(gpu::Recorder& recorder, gpu::StagingRing& staging, const InspectedView& seen,
            settings::DebugView view, const Drawn& drawn, gpu::Image& image);
  // Marks unresolved pixels on an image shaded with shadow maps and rays. listed: the image has a ray list.
  void mark_unresolved(gpu::Recorder& recorder, const InspectedView& seen, ShadowPass& shadows, bool listed,
                       gpu::Image& image);

 private:
  void count(gpu::Recorder& recorder, gpu::StagingRing& staging, const InspectedView& seen,
             const Drawn& drawn);
  void find_range(gpu::Recorder& recorder, const InspectedView& seen, const gpu::Pipeline& pipeline,
                  gpu_types::DebugViewPush push, gpu::Image& image);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  const ImageOverlay& overlay_;
  uint32_t samples_;
  gpu::Pipeline view_, unresolved_;
  std::optional<ClusterRaster> counting_;  // created on first use of the overdraw view
  ClusterTarget counts_;                   // uint64_t[pixel]
  gpu::Buffer range_;                      // DepthRange
};

// Executes an Inspection. Pipelines are created on first use.
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
