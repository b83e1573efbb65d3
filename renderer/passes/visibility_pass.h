// The compute path: the nearest triangle of every sample into a visibility buffer, then its shading from the
// ids.
#pragma once

#include <array>

#include "renderer/gpu/descriptors.h"
#include "renderer/passes/cluster_raster.h"
#include "renderer/passes/post_pass.h"
#include "renderer/passes/shadow_pass.h"
#include "renderer/passes/targets.h"
#include "renderer/passes/view.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

class VisibilityPass {
 public:
  // samples: 1 or 4.
  VisibilityPass(gpu::Device& device, VkPipelineLayout layout, VkDescriptorSetLayout scene_set_layout,
                 uint32_t samples);

  // Has a pipeline made that frames will be shaded with: on a CPU it takes longer than any other.
  struct Shading {
    bool core_materials = true;  // none with more than glTF's core
    bool leaves_samples = false;
    bool finds_shadows = false;
  };
  void expect(const Shading& shading) { shade_pipeline(shading); }

  void set_size(Targets& targets);  // after each change
  // The camera's part of ClusterRaster::record.
  ClusterRaster& prepare(gpu::UploadBelt& belt, GpuScene& scene, const View& view, VkDeviceAddress globals,
                         Cull cull, bool levels_of_detail);
  // Of what was drawn: makes one surface of neighbouring triangles that share a pixel. Before all that
  // follows.
  void merge_surfaces(gpu::Recorder& recorder, GpuScene& scene, VkDeviceAddress globals);
  // Tone-mapped, resolved colour into targets.display; or, for what goes on top, linear samples into
  // targets.hdr, which needs can_leave_samples().
  void shade(gpu::Recorder& recorder, GpuScene& scene, ShadowPass& shadows, Targets& targets,
             VkDeviceAddress globals, const PostSettings& settings, bool leave_samples);
  // The same where shading finds the shadows: see ShadowPass::found_while_shading.
  void shade_and_trace(gpu::Recorder& recorder, GpuScene& scene, ShadowPass& shadows, Targets& targets,
                       VkDeviceAddress globals, const PostSettings& settings, bool leave_samples);
  bool can_leave_samples() const { return samples_ == 1 || device_.report().multisample_storage; }
  gpu::Buffer& buffer() { return visibility_; }
  const ClusterRaster::Drawn& drawn() const { return raster_.drawn(); }

 private:
  enum class Shades : uint8_t { all, all_and_lists, listed };  // pixels

  gpu::Pipeline& shade_pipeline(const Shading& shading);
  void record_shade(gpu::Recorder& recorder, const char* name, Shades what, GpuScene& scene,
                    ShadowPass& shadows, Targets& targets, gpu_types::ShadePush push, bool leave_samples);

  gpu::Device& device_;
  uint32_t samples_;
  VkPipelineLayout layout_;
  ClusterRaster raster_;
  gpu::Pipeline surfaces_;  // of 4 samples
  gpu::SetLayout image_set_layout_;
  gpu::PipelineLayout shade_layout_;
  std::array<gpu::Pipeline, 8> shade_;  // made when they are expected or first used
  gpu::DescriptorSet image_set_;
  VkExtent2D extent_{};
  gpu::Buffer visibility_;  // uint64_t[pixel][sample]
};

// Frustum planes, inwards, from a projection with depth between 0 and w.
gpu_types::RasterView raster_view(const View& view, VkExtent2D extent, bool levels_of_detail);

}  // namespace fire3dv::passes
