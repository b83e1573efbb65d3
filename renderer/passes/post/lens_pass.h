// Lens distortion pass: resamples a pinhole image with its colours and planes. See lens.h.
#pragma once

#include <vector>

#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/gpu/staging_ring.h"
#include "renderer/passes/outputs/plane_layout.h"
#include "renderer/passes/post/lens.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Outputs of the pinhole image that the pass needs.
ImageOutputs pinhole_outputs(ImageOutputs outputs);

class LensPass {
 public:
  explicit LensPass(gpu::Device& device);

  // The pinhole image, with pinhole_outputs() of the requested outputs.
  struct Source {
    const Intrinsics& pinhole;
    gpu::Image* color;    // null: not requested
    gpu::Buffer* planes;  // null: not requested
    std::span<const PlaneRange> places;
  };
  struct Wanted {
    const Intrinsics& camera;
    const Lens& lens;
    const ImageOutputs& outputs;
  };
  // Allocates the memory that a following record() of these needs.
  void make_room(const Intrinsics& pinhole, const Wanted& wanted);
  // Writes result(): colours, 4 bytes a pixel, if requested, then the planes in the layout of
  // lay_out_planes().
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source, const Wanted& wanted);
  gpu::Buffer& result() { return result_; }
  uint64_t result_bytes() const { return result_bytes_; }
  const std::vector<PlaneRange>& places() const { return places_; }

 private:
  void copy_color(gpu::Recorder& recorder, gpu::Image& color);
  gpu_types::LensWanted describe(const Source& source, const Wanted& wanted) const;

  gpu::Device& device_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer color_, result_;
  uint64_t result_bytes_ = 0;
  std::vector<PlaneRange> places_;
};

}  // namespace fire3dv::passes
