#include "renderer/passes/frame_plan.h"

namespace fire3dv::passes {

FramePlan plan_frame(const FrameFacts& facts, const ImageOutputs& outputs, const Inspection& inspection,
                     uint32_t views) {
  const ShadowTechnique& technique = facts.shadow_technique;
  // Forward draws continue the samples of compute shading.
  const bool has_markers = facts.has_markers && views == 1;
  const bool can_have_effects = views == 1 && outputs.has(wire::kColorSrgb8);
  const bool has_effects = can_have_effects && (facts.bloom || facts.metered || facts.has_optics);
  const bool draws_samples = facts.has_forward_only || has_markers;
  const bool has_lens = views == 1 && outputs.shaded() && facts.depth_of_field;
  const bool needs_samples = draws_samples || has_effects || has_lens;
  const bool can_compute =
      facts.raster_path == settings::RasterPath::visibility && (!needs_samples || facts.can_write_samples);
  FramePlan plan;
  plan.surface_planes = outputs.has_id_planes();
  plan.inspection = inspection.any();
  const bool shows_light_of_scene = outputs.shaded() && !replaces_shading(inspection.debug_view);
  plan.path_resolve = shows_light_of_scene && facts.is_path_traced;
  plan.shading = shows_light_of_scene && !facts.is_path_traced;
  plan.compute_shading = plan.shading && can_compute;
  plan.ray_effects = plan.compute_shading && facts.ray_effects && views == 1;

  plan.shadows = plan.shading && facts.shadows_on;
  const bool traced = plan.shadows && technique.method == settings::ShadowMethod::ray;
  plan.acceleration_structures = (traced && facts.has_lights) || plan.ray_effects;
  // The fragment shader of the forward path traces ray queries itself.
  plan.shadow_mask = traced && (can_compute || technique.back_end == settings::RayBackEnd::pipeline);

  plan.visibility_buffer = plan.compute_shading || plan.shadow_mask || plan.surface_planes || plan.inspection;
  plan.coverage_merge = plan.shading && plan.visibility_buffer;
  // The forward path draws LOD 0 only, and its mask must match that.
  if (can_compute && facts.levels_of_detail != settings::LevelsOfDetail::off && facts.scene_has_levels)
    plan.camera_levels = facts.levels_of_detail == settings::LevelsOfDetail::surface
                             ? CameraLevels::by_surface
                             : CameraLevels::by_appearance;
  plan.shadow_maps = plan.shadows && facts.needs_shadow_maps;
  plan.shadow_map_levels_of_detail =
      plan.camera_levels != CameraLevels::finest &&
      (facts.levels_of_detail == settings::LevelsOfDetail::everywhere || technique.small_maps);

  plan.depth_of_field = has_lens && plan.compute_shading;
  const bool shows_light = can_have_effects && (plan.shading || plan.path_resolve);
  plan.metering = facts.metered && shows_light;
  plan.bloom = facts.bloom && shows_light;
  plan.sensor = facts.has_optics && shows_light;
  plan.mask_planes = facts.has_mask && views == 1 && outputs.has_planes();
  plan.hdr_samples = plan.compute_shading && (needs_samples || outputs.has(wire::kColorLinearF16));
  if (!plan.shading) return plan;
  plan.fxaa_only = views > 1;
  if (views > 1) return plan;  // compute shading has tone-mapped images of several views
  plan.forward = !plan.compute_shading || draws_samples;
  plan.markers = has_markers;
  plan.tone_map = !plan.compute_shading || needs_samples;
  plan.linear = outputs.has(wire::kColorLinearF16);
  plan.fxaa_only = !plan.tone_map && !plan.linear;
  return plan;
}

}  // namespace fire3dv::passes
