// The compute path: the nearest triangle of every sample into a visibility buffer, then its shading from the
// ids.
#pragma once

#include <array>
#include <span>

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
    bool textures = true;        // some material has any,
    bool second_uv = true;       // and some texture takes the second set of coordinates
    bool leaves_samples = false;
    // How shadows are found: FIRE3DV_SHADOWS_OFF, _MASK or _MAP; or by shading itself, which lists rays.
    uint32_t shadows = FIRE3DV_SHADOWS_OFF;
    bool finds_shadows = false;
  };
  void expect(const Shading& shading);

  // Borrowed: what is drawn into from now on.
  void set_targets(Targets& targets);
  void forget_targets() { targets_ = nullptr; }
  // So that a prepare() of as many views as the targets have takes no more memory.
  void make_room(GpuScene& scene, Cull cull, bool levels_of_detail);
  // Before what describes what this frame draws.
  void begin() { targets_->visibility.begin(targets_->visibility.buffer.size_bytes); }
  // The cameras' part of ClusterRaster::record: as many views as the targets hold.
  ClusterRaster& prepare(gpu::UploadBelt& belt, GpuScene& scene, std::span<const View> views,
                         VkDeviceAddress globals, Cull cull, bool levels_of_detail);
  // Of what was drawn: makes one surface of neighbouring triangles that share a pixel. Before all that
  // follows, and where it pays. traced: rays may start from what is merged.
  void merge_surfaces(gpu::Recorder& recorder, GpuScene& scene, std::span<const VkDeviceAddress> globals,
                      bool traced);
  // Some of the views, one after the other.
  struct Shaded {
    uint32_t first_view = 0;
    std::span<const View> views;
    std::span<const VkDeviceAddress> globals;
    uint32_t shadows = FIRE3DV_SHADOWS_OFF;  // how they are found, as the globals say it
  };
  // Tone-mapped, resolved colour into targets.display; or, where something goes on top, linear samples into
  // targets.hdr, which needs can_leave_samples(). left: where that can be; null: nowhere.
  void shade(gpu::Recorder& recorder, GpuScene& scene, ShadowPass& shadows, Targets& targets,
             const Shaded& shaded, const PostSettings& settings, const VkRect2D* left);
  // The same of one view where shading finds the shadows: see ShadowPass::found_while_shading.
  void shade_and_trace(gpu::Recorder& recorder, GpuScene& scene, ShadowPass& shadows, Targets& targets,
                       const Shaded& shaded, const PostSettings& settings, const VkRect2D* left);
  // Whether shading that leaves samples shows what lies beyond `left`, tone-mapped and resolved.
  bool shows_the_rest(const GpuScene& scene) const {
    return !scene.has_extensions && gpu::takes_cpu_variants(device_);
  }
  bool can_leave_samples() const { return samples_ == 1 || device_.report().multisample_storage; }
  gpu::Buffer& buffer() { return targets_->visibility.buffer; }
  VkDeviceAddress address_of(uint32_t view) const {
    return targets_->visibility.buffer.address + view * view_bytes_;
  }
  const ClusterRaster::Drawn& drawn() const { return raster_.drawn(); }
  void expect_masks() { raster_.expect_masks(); }  // as ClusterRaster has it

 private:
  enum class Shades : uint8_t { all, all_and_lists, listed };  // pixels

  ClusterRaster::Job job_of(GpuScene& scene, Cull cull, bool levels_of_detail) const;
  void bind(Targets& targets) const;
  gpu_types::ShadePush shade_push(const Shaded& shaded, size_t index, const PostSettings& settings) const;
  gpu::Pipeline& shade_pipeline(const Shading& shading);
  // Whether what finds shadows shades the pixels that are listed, too: a CPU takes long to make a pipeline, a
  // GPU has less room in flight for one that can do both.
  bool shades_listed_by_the_same(const Shading& shading) const {
    return shading.core_materials && gpu::takes_cpu_variants(device_);
  }
  void record_shade(gpu::Recorder& recorder, const char* name, Shades what, uint32_t shadow_way,
                    GpuScene& scene, ShadowPass& shadows, Targets& targets,
                    std::span<const gpu_types::ShadePush> views, const VkRect2D* left);

  gpu::Device& device_;
  uint32_t samples_;
  VkPipelineLayout layout_;
  ClusterRaster raster_;
  gpu::Pipeline surfaces_;  // of 4 samples
  gpu::SetLayout image_set_layout_;
  gpu::PipelineLayout shade_layout_;
  std::array<gpu::Pipeline, 64> shade_;  // made when they are expected or first used
  Targets* targets_ = nullptr;           // null: none that are whole
  VkExtent2D extent_{};
  VkDeviceSize view_bytes_ = 0;
};

// Frustum planes, inwards, from a projection with depth between 0 and w.
gpu_types::RasterView raster_view(const View& view, VkExtent2D extent, bool levels_of_detail);

}  // namespace fire3dv::passes
