// Depth of field: blurs the HDR samples of a perspective image as a thin lens does (Jimenez 2014; Abadie
// 2018). It reads no earlier image. Depths are those of the visibility buffer: blended surfaces, lines and
// points are blurred with the surface behind them.
#pragma once

#include "renderer/gpu/recorder.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view/view.h"

namespace fire3dv::passes {

// Signed radius of the circle of confusion in pixels: at_zero + per_depth * reversed depth. Negative before
// the plane in focus. With fx and fy that differ it is an ellipse of pixels; the radius is the longer one.
struct CircleOfConfusion {
  float at_zero = 0, per_depth = 0;
  float background = 0;  // at infinity
  glm::vec2 stretch{1};  // longer radius over that in x and y
};

// view: perspective, with a lens that is no pinhole.
CircleOfConfusion circle_of_confusion(const View& view, const scene::ThinLens& lens, VkExtent2D image);

class DepthOfFieldPass {
 public:
  // samples: of the HDR target; 1, or with storage of samples 4.
  DepthOfFieldPass(gpu::Device& device, VkSampleCountFlagBits samples);

  // Creates buffers for images of this size, and binds the targets.
  void allocate(Targets& targets);
  // Blurs targets.hdr. targets.visibility has the depths of the image. globals: address of its ImageGlobals.
  void record(gpu::Recorder& recorder, Targets& targets, VkDeviceAddress globals,
              const CircleOfConfusion& circle);

 private:
  gpu::Device& device_;
  ImageFilter split_, gather_;
  gpu::Buffer texels_, tiles_;  // gpu_types::BlurTexel[pixel], BlurTile[tile]
};

}  // namespace fire3dv::passes
