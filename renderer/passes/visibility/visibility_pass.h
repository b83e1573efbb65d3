// Compute raster path: draws ids into a visibility buffer, then shades from the ids.
#pragma once

#include <map>
#include <span>

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/passes/post/post_pass.h"
#include "renderer/passes/raster/cluster_raster.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/shadows/shadow_pass.h"
#include "renderer/passes/view/camera_levels.h"
#include "renderer/passes/view/view.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

class VisibilityPass {
 public:
  // samples: 1 or 4.
  VisibilityPass(gpu::Device& device, VkPipelineLayout layout, VkDescriptorSetLayout scene_set_layout,
                 uint32_t samples);

  // Variant of the shading pipeline. expect() starts its compilation, which on a CPU takes longer than any
  // other.
  struct Shading {
    bool core_materials = true;                           // no material has extensions
    bool textures = true;                                 // a material has textures
    bool second_uv = true;                                // a texture uses the second set of coordinates
    uint32_t material_flags = FIRE3DV_MATERIAL_OPTIONAL;  // of them those that a material has
    bool writes_samples = false;
    // Shadow technique: FIRE3DV_SHADOWS_OFF, _MASK or _MAP. With tests_maps, shading tests maps and lists
    // rays.
    uint32_t shadows = FIRE3DV_SHADOWS_OFF;
    bool tests_maps = false;
    bool ray_effects = false;  // reads them; without core_materials
    bool common = false;       // all views in one dispatch
  };
  void expect(const Shading& shading);
  // Starts compilation of the pipelines that draw all views in common dispatches, if missing. shades: with
  // these shadows, as in Shaded. traced: as for merge_coverage().
  void expect_common(const GpuScene& scene, bool shades, uint32_t shadows, bool merges, bool traced);

  // Targets are borrowed until the next call.
  void set_targets(Targets& targets);
  void reset_targets() { targets_ = nullptr; }
  // Allocates the memory of a following prepare() with the targets' number of views.
  void allocate(GpuScene& scene, settings::Cull cull, CameraLevels levels);
  // Call it before the parameters of this frame's drawing are described.
  void begin() { targets_->visibility.begin(targets_->visibility.buffer.size_bytes); }
  // Prepares the cameras' part of ClusterRaster::record, with the targets' number of views. globals: of each.
  // common: all views in common dispatches.
  ClusterRaster& prepare(gpu::StagingRing& staging, GpuScene& scene, std::span<const View> views,
                         std::span<const VkDeviceAddress> globals, bool common, settings::Cull cull,
                         CameraLevels levels);
  // Coverage merge: neighbouring triangles of a pixel become one shading sample. Runs only where it pays,
  // before all users of the ids. traced: rays may start from merged surfaces. common: not null: one dispatch
  // for all views, whose parameters it holds.
  void merge_coverage(gpu::Recorder& recorder, GpuScene& scene, std::span<const VkDeviceAddress> globals,
                      bool traced, gpu::StagingRing* common);
  // A range of views, shaded in sequence. With ray effects, one view and Targets::ray_effects.
  struct Shaded {
    uint32_t first_view = 0;
    std::span<const View> views;
    std::span<const VkDeviceAddress> globals;
    uint32_t shadows = FIRE3DV_SHADOWS_OFF;  // shadow technique, as in the globals
    bool ray_effects = false;
    gpu::StagingRing* common = nullptr;  // as for merge_coverage()
  };
  // Linear samples that shading writes into targets.hdr, which needs can_write_samples().
  struct Samples {
    bool any = false;
    VkRect2D unresolved{};  // pixels left to the tone-map pass: all or none, unless tone_maps_other_pixels()
    bool all = false;       // samples of the other pixels too, for the linear plane
  };
  // Shades into targets.display, tone-mapped and resolved, except for unresolved pixels.
  void shade(gpu::Recorder& recorder, GpuScene& scene, ShadowPass& shadows, Targets& targets,
             const Shaded& shaded, const settings::PostSettings& settings, const Samples& samples);
  // The same for one view with shadow tests in shading; see ShadowPass::tests_maps_while_shading.
  void shade_and_trace(gpu::Recorder& recorder, GpuScene& scene, ShadowPass& shadows, Targets& targets,
                       const Shaded& shaded, const settings::PostSettings& settings, const Samples& samples);
  // True if shading can leave a part of the image unresolved and tone-map the rest.
  bool tone_maps_other_pixels(const GpuScene& scene, bool ray_effects) const {
    return !scene.has_extensions && !ray_effects && gpu::uses_cpu_variants(device_);
  }
  bool can_write_samples() const { return samples_ == 1 || device_.report().multisample_storage; }
  gpu::Buffer& buffer() { return targets_->visibility.buffer; }
  VkDeviceAddress address_of(uint32_t view) const {
    return targets_->visibility.buffer.address + view * view_bytes_;
  }
  const ClusterRaster::Drawn& drawn() const { return raster_.drawn(); }
  void expect_masks() { raster_.expect_masks(); }  // see ClusterRaster

 private:
  enum class Shades : uint8_t { all, all_and_lists, listed };  // pixels

  ClusterRaster::Job job_of(GpuScene& scene, settings::Cull cull, CameraLevels levels) const;
  void bind(Targets& targets) const;
  gpu_types::ShadePush shade_push(const Shaded& shaded, size_t index,
                                  const settings::PostSettings& settings) const;
  gpu::Pipeline& shade_pipeline(const Shading& shading);
  static Shading shading_of(const GpuScene& scene, uint32_t shadows, bool writes_samples, bool ray_effects);
  bool merge_pays(const GpuScene& scene, bool traced) const;
  void make_common_merge();
  // True if one pipeline both lists unresolved pixels and re-shades them. A CPU compiles pipelines slowly; on
  // a GPU the combined pipeline would lower occupancy.
  bool shares_pipeline_with_listed(const Shading& shading) const {
    return shading.core_materials && gpu::uses_cpu_variants(device_);
  }
  void record_shade(gpu::Recorder& recorder, const char* name, Shades what, uint32_t shadow_technique,
                    GpuScene& scene, ShadowPass& shadows, Targets& targets,
                    std::span<gpu_types::ShadePush> views, const Samples& samples,
                    gpu::StagingRing* common = nullptr);

  gpu::Device& device_;
  uint32_t samples_;
  VkPipelineLayout layout_;
  ClusterRaster raster_;
  gpu::Pipeline merge_coverage_[2];  // 4 samples only; a dispatch for each view, and for all
  gpu::SetLayout image_set_layout_;
  gpu::PipelineLayout shade_layout_;
  std::map<uint32_t, gpu::Pipeline> shade_;  // by variant; created by expect() or on first use
  Targets* targets_ = nullptr;               // null: no complete targets
  VkExtent2D extent_{};
  VkDeviceSize view_bytes_ = 0;
};

// Frustum planes point inwards, from a projection with depth between 0 and w.
gpu_types::RasterView raster_view(const View& view, VkExtent2D extent, CameraLevels levels);

}  // namespace fire3dv::passes
