// Flow and occlusion from an earlier image of a camera to the current one. Deformation is included.
#pragma once

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/outputs/camera_history.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/view/view.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Of an image: two floats a pixel, then one uint32 a pixel (wire::kOcclusionU32).
constexpr VkDeviceSize flow_bytes(VkExtent2D extent) {
  return VkDeviceSize{12} * extent.width * extent.height;
}

// Of an image: SurfaceReference[pixel].
VkDeviceSize surfaces_bytes(VkExtent2D extent);

class FlowPass {
 public:
  // samples: 1 or 4, of the visibility buffer.
  FlowPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples);

  // Allocates the result of such an image.
  void make_room(VkExtent2D extent) { gpu::grow_storage_buffer(device_, result_, flow_bytes(extent)); }

  // The current image.
  struct Shown {
    GpuScene& gpu_scene;
    const View& view;
    VkDeviceAddress globals;
    gpu::Buffer& visibility;  // with the blended surfaces that have labels
    VkExtent2D extent;
  };
  // Writes the surface point of each pixel.
  void keep_surfaces(gpu::Recorder& recorder, const Shown& shown, gpu::Buffer& surfaces);

  // The current image, with its depth plane.
  struct Source {
    GpuScene& gpu_scene;
    const View& view;
    VkDeviceAddress globals;
    gpu::Buffer& planes;
    VkDeviceAddress depth;  // in the planes
    gpu::Buffer& labels;    // PartLabels[part]
    VkExtent2D extent;
  };
  // earlier: of the same scene, with surfaces of the same size.
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
              const CameraHistory& earlier);
  // Each pixel of the earlier image: pixels right and down to where the current one shows its point, NaN if
  // behind the camera or hidden as a node; and the point's occlusion in the current one.
  gpu::Buffer& result() { return result_; }

 private:
  gpu::Device& device_;
  VkPipelineLayout layout_;
  gpu::Pipeline surfaces_pipeline_, pipeline_;
  gpu::Buffer result_;
};

}  // namespace fire3dv::passes
