// Which lights reach which pixels: a list of rays becomes a mask. Lights' maps tell what needs no ray; the
// rest is traced by ray query or by a ray-tracing pipeline. Where there are neither rays nor the wish for
// them, shading looks into the maps itself.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "renderer/gpu/ray_pipeline.h"
#include "renderer/passes/cluster_raster.h"
#include "renderer/passes/patches.h"
#include "renderer/passes/shadow_plan.h"
#include "renderer/passes/targets.h"

namespace fire3dv::gpu_types {
struct Globals;
struct ShadowPush;
}  // namespace fire3dv::gpu_types

namespace fire3dv::passes {

enum class ShadowMethod : uint8_t { automatic, ray, map, off };
enum class RayBackEnd : uint8_t { none, query, pipeline };

struct ShadowSettings {
  ShadowMethod method = ShadowMethod::automatic;
  bool hybrid = true;  // maps first, rays where they cannot tell; false: a ray for every lit surface
  RayBackEnd back_end = RayBackEnd::query;  // used if the device has it, else the other one
  uint32_t map_side = 0;    // texels along a map, a power of two; 0: as suits the device and the image
  uint32_t most_found = 0;  // rays that are kept as they are found; 0: as many as half of the pixels
  bool operator==(const ShadowSettings&) const = default;
};

// What a device makes of the settings.
struct ShadowWay {
  ShadowMethod method = ShadowMethod::off;  // never automatic
  RayBackEnd back_end = RayBackEnd::none;
  bool hybrid = false;
  uint32_t map_side = 0, most_found = 0;  // as in the settings
  bool operator==(const ShadowWay&) const = default;
};
// compute: the image is drawn from a visibility buffer. Else, where there are ray queries, shading traces by
// itself.
ShadowWay choose_shadow_way(const gpu::Device& device, const ShadowSettings& settings, bool compute);
const char* describe(const ShadowWay& way);

class ShadowPass {
 public:
  // samples: 1 or 4, of the visibility buffer.
  ShadowPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples, const ShadowWay& way);

  // On a VulkanFailure everything stays as it was for the scene before.
  void set_scene(const scene::Scene& scene, const GpuScene& gpu_scene);
  // As ClusterRaster has it.
  void expect_masks() {
    if (map_raster_) map_raster_->expect_masks();
  }
  // Other lights, or the same ones with another shape. Without memory for their shadows they cast none.
  void set_lights_or_drop_shadows(const std::vector<scene::PlacedLight>& lights);
  // Of what is not hidden.
  void choose_sheets(const scene::Scene& scene, const GpuScene& gpu_scene);
  // What these have chosen, for the frame that begins. Most have nothing.
  void upload_choices(gpu::Recorder& recorder, gpu::UploadBelt& belt);
  // Borrowed: what is drawn into from now on.
  void set_targets(Targets& targets);
  void forget_targets() { targets_ = nullptr; }
  void describe_to(gpu_types::Globals& globals) const;
  // FIRE3DV_SHADOWS_*. masked: shading reads the mask; else it traces where it shades, or reads maps.
  uint32_t number_of_way(bool masked) const;

  bool needs_maps() const { return state_.needs_maps; }
  // Before what describes this frame's maps.
  void begin_maps() { state_.maps.begin(map_bytes()); }
  // The lights' maps, to be drawn beside the camera's view; null when there is no light.
  ClusterRaster* prepare_maps(gpu::UploadBelt& belt, GpuScene& scene, VkDeviceAddress globals, Cull cull,
                              bool levels_of_detail);
  // Where they look, and what else maps and those who ask them need to know of the scene; `beside` that,
  // which hardly occupies a GPU, what is drawn into is emptied. globals: of each camera.
  void place_maps(gpu::Recorder& recorder, gpu::UploadBelt& belt, GpuScene& scene,
                  std::span<const VkDeviceAddress> globals, bool levels_of_detail,
                  ClusterRaster::Emptying beside);
  // The visibility buffer of one view.
  struct Visibility {
    gpu::Buffer& buffer;
    VkDeviceAddress address;
  };
  // From there to the mask.
  void record(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
              VkDeviceAddress globals);
  // Or shading itself asks the maps and lists the pixels that need rays, and these; then they are traced.
  bool found_while_shading() const;
  // Before each view's.
  void empty_lists(gpu::Recorder& recorder);
  void trace_found(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
                   VkDeviceAddress globals);
  gpu::Buffer& lists() { return lists_; }  // gpu_types::RayList[FIRE3DV_RAY_LISTS]
  gpu::Buffer& entries() { return targets_->shadow_entries; }
  gpu::Buffer& found() { return targets_->found_rays; }
  uint32_t found_room() const;  // how many rays there can be; others are traced pixel by pixel
  gpu::Buffer& mask() { return targets_->shadow_mask; }
  // Of whoever shades, with this access.
  void add_reads(std::vector<gpu::Use>& uses, const gpu::Access& access);
  void add_map_reads(std::vector<gpu::Use>& uses, const gpu::Access& access);

  // Whether anything meets the top level: in the passes here, or where something is shaded.
  bool traces() const { return way_.method == ShadowMethod::ray && state_.light_count > 0; }
  uint64_t rays_traced() const { return rays_traced_; }  // two frames ago
  // Lights that cast no shadow since the device has no room for their maps or mask bits.
  uint32_t lights_without_shadow() const { return state_.plan.lights_without_shadow; }

 private:
  struct Tracing {
    gpu::Pipeline query;  // one of both
    gpu::RayPipeline pipeline;
  };

  void make_classify();
  bool finds_while_shading(const ShadowPlan& plan) const;
  // On a VulkanFailure the lights before stay.
  void set_lights(const std::vector<scene::PlacedLight>& lights, const ShadowRoom& room);
  struct ViewsPlace {
    gpu::Buffer buffer;  // null: the old one stays
    VkDeviceSize sheets_offset = 0, far_sides_offset = 0;
  };
  ViewsPlace place_views(uint32_t view_count, uint32_t sheet_count) const;
  void use_views(ViewsPlace&& place);
  MapSizes map_sizes() const;
  ShadowRoom shadow_room() const;
  VkDeviceSize map_bytes() const { return VkDeviceSize{state_.plan.texels} * sizeof(uint32_t); }
  void make_room_for_mask(const ShadowPlan& plan);
  gpu_types::ShadowPush push(const Visibility& visibility, VkDeviceAddress globals) const;
  void trace(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility, VkDeviceAddress globals,
             bool found);
  void record_trace(VkCommandBuffer commands, const Tracing& tracing, uint32_t list, GpuScene& scene,
                    const gpu_types::ShadowPush& push) const;
  void bind(VkCommandBuffer commands, VkPipelineBindPoint point, VkPipeline pipeline, GpuScene& scene,
            const gpu_types::ShadowPush& push) const;

  gpu::Device& device_;
  VkPipelineLayout layout_;
  uint32_t samples_;
  ShadowWay way_;
  gpu::Pipeline light_views_, classify_;
  Tracing trace_pixels_, trace_found_;
  std::optional<ClusterRaster> map_raster_;
  Targets* targets_ = nullptr;
  // What depends on the scene and its lights; replaced as a whole, so that a failure leaves the old one.
  struct State {
    bool needs_maps = false;
    uint32_t max_mask_words = 0;  // as of the plan
    uint32_t view_count = 0, light_count = 0, sheet_count = 0, part_count = 0, cluster_count = 0;
    ShadowPlan plan;
    std::vector<scene::PlacedLight> lights;
    gpu::Buffer light_shadows, wanted_views, views, sheets;
    ClusterTarget maps;
    VkDeviceSize sheets_offset = 0, far_sides_offset = 0;  // in views: SheetPlace[], uint[part]
    std::vector<gpu_types::SheetRecord> sheet_records;
    bool lights_chosen = false, sheets_chosen = false;  // and not uploaded yet
  };
  State state_;
  gpu::Buffer lists_;
  std::array<gpu::Buffer, gpu::kFramesInFlight> lists_seen_;
  uint64_t frame_ = 0, rays_traced_ = 0;
};

}  // namespace fire3dv::passes
