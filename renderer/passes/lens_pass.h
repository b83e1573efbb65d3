// Makes an image through a lens of a pinhole's image: colours and planes alike. See lens.h.
#pragma once

#include <vector>

#include "renderer/gpu/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/gpu/upload_belt.h"
#include "renderer/passes/image_outputs.h"
#include "renderer/passes/lens.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// What the pinhole's image must consist of for that.
ImageOutputs behind_lens(ImageOutputs outputs);

class LensPass {
 public:
  explicit LensPass(gpu::Device& device);

  // The pinhole's image, with behind_lens() of what is wanted.
  struct Source {
    const Intrinsics& pinhole;
    gpu::Image* color;    // null: none is wanted
    gpu::Buffer* planes;  // null: neither
    std::span<const PlanePlace> places;
  };
  struct Wanted {
    const Intrinsics& camera;
    const Lens& lens;
    const ImageOutputs& outputs;
  };
  // So that a record() of these that follows takes no more memory.
  void make_room(const Intrinsics& pinhole, const Wanted& wanted);
  // Into result(): colours, 4 bytes a pixel, where they are wanted, and behind them the planes as
  // place_planes() has them.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, const Source& source, const Wanted& wanted);
  gpu::Buffer& result() { return result_; }
  uint64_t result_bytes() const { return result_bytes_; }
  const std::vector<PlanePlace>& places() const { return places_; }

 private:
  void copy_color(gpu::Recorder& recorder, gpu::Image& color);
  gpu_types::LensWanted describe(const Source& source, const Wanted& wanted) const;

  gpu::Device& device_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer color_, result_;
  uint64_t result_bytes_ = 0;
  std::vector<PlanePlace> places_;
};

}  // namespace fire3dv::passes
