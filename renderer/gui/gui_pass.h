// Compute pass that draws panels onto a finished image. On large GPUs it is several times as fast as
// rasterisation. Pixels without a panel are not accessed.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "shaders/shared/gui_types.h"

struct ImDrawData;
struct ImFontAtlas;

namespace fire3dv::gui {

// Tile lists of panels for the GPU: ImGui's output as rectangles and triangles, binned into image tiles.
// Empty tiles are omitted, and primitives behind an opaque rectangle are dropped.
class GuiTiles {
 public:
  // Builds the lists for an image of this size. Valid until the next call.
  void build(const ImDrawData& draw_data, glm::uvec2 image_px);

  const std::vector<gpu_types::GuiPrimitive>& primitives() const { return primitives_; }
  const std::vector<gpu_types::GuiTile>& tiles() const { return tiles_; }
  // Primitive indices of the tiles, in drawing order.
  const std::vector<uint32_t>& entries() const { return entries_; }

 private:
  struct Link {
    uint32_t primitive, next;
  };
  void add(const ImDrawData& draw_data);
  void link(uint32_t primitive, glm::uvec2 grid);

  glm::vec2 image_px_{0};
  std::vector<gpu_types::GuiPrimitive> primitives_;
  std::vector<gpu_types::GuiTile> tiles_;
  std::vector<uint32_t> entries_, head_;
  std::vector<Link> links_;
  std::vector<bool> covered_;
};

class GuiPass {
 public:
  explicit GuiPass(gpu::Device& device);

  // fonts_number: a new number uploads the fonts. The image is rgba8 with sRGB-encoded colours, and may
  // differ between calls.
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Image& image,
              const ImDrawData& draw_data, const ImFontAtlas& fonts, uint64_t fonts_number);

 private:
  void upload_fonts(gpu::Recorder& recorder, gpu::StagingRing& staging, const ImFontAtlas& fonts);
  void bind(const gpu::Image& image);

  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Sampler sampler_;
  gpu::DescriptorSet set_;
  gpu::Image fonts_;
  uint64_t fonts_number_ = 0;  // number of the uploaded fonts; 0: none
  GuiTiles tiles_;
};

}  // namespace fire3dv::gui
