// Shadow pass: computes the shadow mask of all lights. Shadow maps resolve the certain pixels. The rest is
// traced by ray query or by a ray-tracing pipeline. Without rays, shading samples the maps directly.
#pragma once

#include <optional>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/raster/cluster_raster.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/shadows/shadow_plan.h"

namespace fire3dv::gpu_types {
struct Globals;
struct ShadowPush;
}  // namespace fire3dv::gpu_types

namespace fire3dv::passes {

class ShadowPass {
 public:
  // samples: 1 or 4, of the visibility buffer.
  ShadowPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples,
             const ShadowTechnique& technique);

  // On a VulkanFailure the earlier scene's state stays.
  void set_scene(const scene::Scene& scene, const GpuScene& gpu_scene);
  // See ClusterRaster.
  void expect_masks() {
    if (map_raster_) map_raster_->expect_masks();
  }
  // The same for pipelines that draw the maps of several worlds.
  void expect_worlds(bool masks);
  // Sets new lights, or new shapes of lights. Without memory for their shadows they cast none.
  void set_lights_or_drop_shadows(const std::vector<scene::PlacedLight>& lights);
  // Selects planar casters among visible nodes.
  void choose_planar_casters(const scene::Scene& scene, const GpuScene& gpu_scene);
  // Uploads the choices of these calls for this frame, if any.
  void upload_changes(gpu::Recorder& recorder, gpu::StagingRing& staging);
  // Targets are borrowed until the next call.
  void set_targets(Targets& targets);
  void reset_targets() { targets_ = nullptr; }
  void write_globals(gpu_types::Globals& globals) const;  // of all views
  // map_set: of the view's world, see MapSets.
  void write_map_globals(gpu_types::Globals& globals, uint32_t map_set) const;
  // FIRE3DV_SHADOWS_*. masked: shading reads the mask; otherwise it traces inline or reads maps.
  uint32_t shader_mode(bool masked) const;

  bool needs_maps() const { return state_.needs_maps; }
  // Each world that a frame shows has a set of maps, fitted to its cameras.
  struct MapSets {
    uint32_t count = 0;
    std::vector<VkDeviceAddress> cameras;  // globals of the views, by set
    std::vector<uint32_t> first;           // camera of each set; behind them, the number of cameras

    // set_of and globals: by view. Within a set, cameras keep their order.
    void set_cameras(std::span<const uint32_t> set_of, std::span<const VkDeviceAddress> globals);
  };
  // Call it before this frame's maps are described.
  void begin_maps(size_t sets) { state_.maps.begin(map_bytes(sets)); }
  // Prepares the shadow maps, which are drawn together with the camera's view. Null without lights.
  ClusterRaster* prepare_maps(gpu::StagingRing& staging, GpuScene& scene, const MapSets& sets,
                              settings::Cull cull, bool levels_of_detail);
  // Computes the maps' views and per-part shadow data. clear: clear that overlaps with this small dispatch.
  void fit_map_views(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene, const MapSets& sets,
                     bool levels_of_detail, ClusterRaster::Clear clear);
  // Visibility buffer of one view.
  struct Visibility {
    gpu::Buffer& buffer;
    VkDeviceAddress address;
  };
  // Computes the mask from the visibility buffer.
  void record(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
              VkDeviceAddress globals);
  // True if shading tests the maps itself and lists unresolved pixels and rays, which trace_listed() traces.
  bool tests_maps_while_shading() const;
  // Call it before each view.
  void clear_ray_lists(gpu::Recorder& recorder);
  void trace_listed(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
                    VkDeviceAddress globals);
  gpu::Buffer& lists() { return lists_; }  // gpu_types::RayList[FIRE3DV_RAY_LISTS]
  gpu::Buffer& entries() { return targets_->shadow_entries; }
  gpu::Buffer& listed_rays() { return targets_->listed_rays; }
  uint32_t ray_list_capacity() const;  // capacity of the ray list; on overflow all pixels are traced
  gpu::Buffer& mask() { return targets_->shadow_mask; }
  // Resources that shading reads, with this access.
  void add_reads(std::vector<gpu::Use>& uses, const gpu::Access& access);
  void add_map_reads(std::vector<gpu::Use>& uses, const gpu::Access& access);

  // True if any pass, or shading itself, traces rays.
  bool traces() const { return technique_.method == settings::ShadowMethod::ray && has_lights(); }
  bool has_lights() const { return state_.light_count > 0; }
  uint64_t rays_traced() const { return rays_traced_; }  // two frames ago
  // Lights without a shadow, for lack of memory for maps or mask bits.
  uint32_t lights_without_shadow() const { return state_.plan.lights_without_shadow; }

 private:
  struct Tracing {
    gpu::Pipeline query;  // one of the two is set
    gpu::RayPipeline pipeline;
  };

  void make_classify();
  void make_light_views_of_worlds();
  bool can_test_maps_while_shading(const ShadowPlan& plan) const;
  // On a VulkanFailure the earlier lights stay.
  void set_lights(const std::vector<scene::PlacedLight>& lights, const ShadowLimits& limits);
  struct ViewsLayout {
    gpu::Buffer buffer;  // null: keeps the old buffer
    VkDeviceSize planar_casters_offset = 0, planar_casters_bytes = 0;
    VkDeviceSize backface_casters_offset = 0, backface_casters_bytes = 0;
  };
  ViewsLayout layout_views(uint32_t view_count, uint32_t planar_caster_count) const;
  void use_views(ViewsLayout&& layout);
  MapSizes map_sizes() const;
  ShadowLimits shadow_limits() const;
  VkDeviceSize map_bytes(size_t sets) const { return sets * state_.plan.texels * sizeof(uint32_t); }
  ShadowPlan make_plan(const std::vector<scene::PlacedLight>& lights, const ShadowLimits& limits) const;
  gpu::Buffer create_maps(ShadowPlan& plan, const std::vector<scene::PlacedLight>& lights,
                          ShadowLimits limits) const;
  void allocate_mask(const ShadowPlan& plan);
  gpu_types::ShadowPush push(const Visibility& visibility, VkDeviceAddress globals) const;
  void trace(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility, VkDeviceAddress globals,
             bool listed);
  void record_trace(VkCommandBuffer commands, const Tracing& tracing, uint32_t list, GpuScene& scene,
                    const gpu_types::ShadowPush& push) const;
  void bind(VkCommandBuffer commands, VkPipelineBindPoint point, VkPipeline pipeline, GpuScene& scene,
            const gpu_types::ShadowPush& push) const;

  gpu::Device& device_;
  VkPipelineLayout layout_;
  uint32_t samples_;
  ShadowTechnique technique_;
  struct Pipelines {
    gpu::Pipeline light_views[2];  // of one world; of several in one dispatch
    gpu::Pipeline classify;
    Tracing trace_pixels, trace_listed;
  };
  Pipelines pipelines_;
  std::optional<ClusterRaster> map_raster_;
  Targets* targets_ = nullptr;
  // State that depends on scene and lights. It is replaced as a whole, so that a failure keeps the old one.
  struct State {
    bool needs_maps = false;
    uint32_t max_mask_words = 0;  // as in the plan
    uint32_t worlds = 1;
    uint32_t view_count = 0;  // of a world
    uint32_t light_count = 0, planar_caster_count = 0, part_count = 0, cluster_count = 0;
    ShadowPlan plan;
    std::vector<scene::PlacedLight> lights;
    gpu::Buffer light_shadows, view_requests, views, planar_casters;
    ClusterTarget maps;
    // In views, behind those of all sets; of each set PlanarCasterPlane[], then of each set uint[part].
    VkDeviceSize planar_casters_offset = 0, planar_casters_bytes = 0;
    VkDeviceSize backface_casters_offset = 0, backface_casters_bytes = 0;
    std::vector<gpu_types::PlanarCasterRecord> planar_caster_records;
    bool lights_changed = false, planar_casters_changed = false;  // pending uploads
  };
  State state_;
  gpu::Buffer lists_;
  std::array<gpu::Buffer, gpu::kFramesInFlight> list_readbacks_;
  uint64_t frame_ = 0, rays_traced_ = 0;
};

}  // namespace fire3dv::passes
