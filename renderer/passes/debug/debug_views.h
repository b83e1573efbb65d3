// Debug view passes; see inspection.h.
#pragma once

#include <optional>

#include "renderer/passes/debug/inspection.h"
#include "renderer/passes/post/image_overlay.h"
#include "renderer/passes/shadows/shadow_pass.h"
#include "renderer/passes/visibility/cluster_raster.h"

namespace fire3dv::passes {

class DebugViews {
 public:
  // layout: of the raster shaders. samples: 1 or 4.
  DebugViews(gpu::Device& device, VkPipelineLayout layout, const ImageOverlay& overlay, uint32_t samples);

  // Draw settings for views that rasterise the scene again.
  struct Drawn {
    Cull cull = Cull::automatic;
    bool levels_of_detail = false;
  };
  // Replaces the whole image. Call it before the coverage merge.
  void show(gpu::Recorder& recorder, gpu::StagingRing& staging, const InspectedView& seen, DebugView view,
            const Drawn& drawn, gpu::Image& image);
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

}  // namespace fire3dv::passes
