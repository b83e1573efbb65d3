// Draws panels onto a finished image, by compute: on a large GPU that is several times as fast as its raster
// pipeline. Pixels without a panel are not touched.
#pragma once

#include <memory>

#include "renderer/gpu/descriptors.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/gpu/upload_belt.h"
#include "renderer/gui/gui_tiles.h"

struct ImDrawData;
struct ImFontAtlas;

namespace fire3dv::gui {

class GuiPass {
 public:
  explicit GuiPass(gpu::Device& device);

  // fonts_number: another one for other fonts, which are uploaded then. The image is rgba8, with colours as
  // displays take them, and may be another one each time.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, gpu::Image& image, const ImDrawData& draw_data,
              const ImFontAtlas& fonts, uint64_t fonts_number);

 private:
  void upload_fonts(gpu::Recorder& recorder, gpu::UploadBelt& belt, const ImFontAtlas& fonts);
  void bind(const gpu::Image& image);

  gpu::Device& device_;
  gpu::SetLayout set_layout_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Sampler sampler_;
  gpu::DescriptorSet set_;
  gpu::Image fonts_;
  uint64_t fonts_number_ = 0;  // of what is uploaded; 0: nothing is
  GuiTiles tiles_;
};

}  // namespace fire3dv::gui
