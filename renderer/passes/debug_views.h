// Draws an image that shows something else than light: see debug_view.h.
#pragma once

#include <optional>

#include "renderer/passes/cluster_raster.h"
#include "renderer/passes/debug_view.h"
#include "renderer/passes/image_overlay.h"
#include "renderer/passes/shadow_pass.h"

namespace fire3dv::passes {

class DebugViews {
 public:
  // layout: of the raster's shaders. samples: 1 or 4.
  DebugViews(gpu::Device& device, VkPipelineLayout layout, const ImageOverlay& overlay, uint32_t samples);

  // How the scene is drawn, for what is counted while it is drawn again.
  struct Drawn {
    Cull cull = Cull::automatic;
    bool levels_of_detail = false;
  };
  // The whole image, before surfaces are merged.
  void show(gpu::Recorder& recorder, gpu::UploadBelt& belt, const SeenView& seen, DebugView view,
            const Drawn& drawn, gpu::Image& image);
  // Over an image that was shaded with shadow maps and rays. listed: shadows were looked for in it.
  void mark_doubt(gpu::Recorder& recorder, const SeenView& seen, ShadowPass& shadows, bool listed,
                  gpu::Image& image);

 private:
  void count(gpu::Recorder& recorder, gpu::UploadBelt& belt, const SeenView& seen, const Drawn& drawn);
  void find_range(gpu::Recorder& recorder, const SeenView& seen, const gpu::Pipeline& pipeline,
                  gpu_types::DebugViewPush push, gpu::Image& image);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  const ImageOverlay& overlay_;
  uint32_t samples_;
  gpu::Pipeline view_, doubt_;
  std::optional<ClusterRaster> counting_;  // made when overdraw is first shown
  ClusterTarget counts_;                   // uint64_t[pixel]
  gpu::Buffer range_;                      // DepthRange
};

}  // namespace fire3dv::passes
