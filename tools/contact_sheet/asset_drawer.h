// Draws scene after scene with one renderer: thousands of assets in one process, since a renderer's start
// costs more than most of them.
#pragma once

#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::contact_sheet {

// What is handed to the GPU, each mesh as often as nodes show it.
struct DrawnCounts {
  uint64_t triangles = 0, lines = 0, points = 0;
  bool operator==(const DrawnCounts&) const = default;
};

class AssetDrawer {
 public:
  AssetDrawer(gpu::Device& device, VkExtent2D extent, const passes::DrawSettings& settings);

  // At rest, waiting for the image.
  sinks::FrameImage draw(const scene::Scene& scene, const passes::View& view);
  sinks::FrameImage draw_framed(const scene::Scene& scene);
  sinks::FrameImage draw_nothing();
  DrawnCounts counts() const;  // of the scene that was drawn last, which must still be there
  float aspect() const;

 private:
  scene::Scene nothing_;
  const scene::Scene* shown_ = &nothing_;
  gpu::FrameRing frames_;
  passes::SceneRenderer renderer_;
  passes::ReadbackBelt<int> readback_;
};

// The whole scene seen obliquely from above, whatever cameras it brings.
passes::View framed_view(const scene::Scene& scene, float image_aspect);

}  // namespace fire3dv::contact_sheet
