// Renderer for many scenes in one process, since starting a renderer costs more than drawing most assets. One
// thread.
#pragma once

#include <optional>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::contact_sheet {

// Primitives sent to the GPU, counted per node that shows them.
struct DrawnCounts {
  uint64_t triangles = 0, lines = 0, points = 0;
  bool operator==(const DrawnCounts&) const = default;
};

class AssetDrawer {
 public:
  AssetDrawer(gpu::Device& device, VkExtent2D extent, const settings::DrawSettings& settings);

  // Draws the scene at rest and waits for the image. Throws std::runtime_error when memory is short. pick: a
  // pixel, whose node take_picked() returns.
  sinks::FrameImage draw(const scene::Scene& scene, const passes::View& view,
                         std::optional<passes::Pick> pick = std::nullopt);
  std::vector<passes::Picked> take_picked() { return renderer_.take_picked(); }
  sinks::FrameImage draw_framed(const scene::Scene& scene);
  // The image of `fire3dv FILE` without options: its camera, ground shadows and exposure. The settings must
  // be default_settings(), but for their techniques.
  sinks::FrameImage draw_by_default(const scene::Scene& scene);
  sinks::FrameImage draw_nothing();
  DrawnCounts counts() const;  // counts of the last drawn scene, which must still exist
  float aspect() const;

 private:
  scene::Scene nothing_;
  const scene::Scene* shown_ = &nothing_;
  gpu::FrameRing frames_;
  passes::SceneRenderer renderer_;
  gpu::ReadbackRing<int> readback_;
  const settings::DrawSettings settings_;
  const VkExtent2D extent_;
};

// Camera view of the whole scene, obliquely from above, independent of the scene's cameras.
passes::View framed_view(const scene::Scene& scene, float image_aspect);

}  // namespace fire3dv::contact_sheet
