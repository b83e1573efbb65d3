// Lens distortion pass: resamples a pinhole image with its colours and planes.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "base/error.h"
#include "protocol/wire/image.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/view/view.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Lens distortion models of OpenCV calibration. Points lie on the plane at distance 1 in front of the camera,
// x to the right and y down.

using wire::Lens;
using wire::LensModel;

// Distorts a pinhole point, as cv::projectPoints and cv::fisheye::projectPoints do.
// plumb_bob: r2 = x^2 + y^2, x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2), and y' with
// p1 and p2 exchanged.
// fisheye: the angle t off the axis becomes t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8).
glm::dvec2 distort(const Lens& lens, const glm::dvec2& point);

// Largest radius of points up to which the distorted radius increases, so that distortion is injective. At
// most about 80 degrees, since a pinhole image ends before 90.
double largest_radius(const Lens& lens);
// Returns the point within largest_radius() that distorts to this one, if any.
std::optional<glm::dvec2> undistort(const Lens& lens, const glm::dvec2& distorted);

// Pinhole camera whose image contains the lens's visible field. Its resolution is twice the lens's at the
// largest magnification. max_side: maximum size of that image in pixels; larger images are scaled down.
// Returns an error when the resolution gets too low.
Result<Intrinsics> pinhole_behind(const Intrinsics& intrinsics, const Lens& lens, uint32_t max_side);

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
    gpu::Buffer* light = nullptr;  // instead of `color`, of a camera with optics: SensorRecord::light
  };
  struct Wanted {
    const Intrinsics& camera;
    const Lens& lens;
    const ImageOutputs& outputs;
    float mask_radius = 0, mask_cut = 0;  // content mask, see OpticsSettings
    bool has_optics = false;              // colours are light(), not result()
  };
  // Allocates the memory that a following record() of these needs.
  void make_room(const Intrinsics& pinhole, const Wanted& wanted);
  // Writes result(): colours, 4 bytes a pixel, if requested, then the planes in the layout of
  // lay_out_planes().
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source, const Wanted& wanted);
  gpu::Buffer& light() { return light_; }  // distorted, of a source with light
  gpu::Buffer& result() { return result_; }
  uint64_t result_bytes() const { return result_bytes_; }
  const std::vector<PlaneRange>& places() const { return places_; }

 private:
  void copy_color(gpu::Recorder& recorder, gpu::Image& color);
  gpu_types::LensWanted describe(const Source& source, const Wanted& wanted) const;

  gpu::Device& device_;
  gpu::PipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer color_, light_, result_;
  uint64_t result_bytes_ = 0;
  std::vector<PlaneRange> places_;
};

}  // namespace fire3dv::passes
