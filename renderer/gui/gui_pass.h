// Compute pass that draws panels onto a finished image. On large GPUs it is several times as fast as
// rasterisation. Pixels without a panel are not accessed.
#pragma once

#include <memory>

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/gpu/staging_ring.h"
#include "renderer/gui/gui_tiles.h"

struct ImDrawData;
struct ImFontAtlas;

namespace fire3dv::gui {

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
