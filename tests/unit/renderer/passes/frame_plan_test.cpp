// Test of frame plans: each output runs the passes that it needs, and no others.
#include "renderer/passes/frame_plan.h"

#include <gtest/gtest.h>

namespace fire3dv::passes {
namespace {

FrameFacts lit_scene() {
  FrameFacts facts;
  facts.scene_has_levels = true;
  facts.shadow_technique.method = settings::ShadowMethod::ray;
  facts.shadow_technique.back_end = settings::RayBackEnd::query;
  facts.shadow_technique.hybrid = true;
  facts.has_lights = true;
  facts.needs_shadow_maps = true;
  return facts;
}

ImageOutputs only(wire::ImageOutput output) {
  return ImageOutputs(output);
}

TEST(FramePlan, ColoursUseMapsRaysCompute) {
  const FramePlan plan = plan_frame(lit_scene(), {}, {});
  EXPECT_TRUE(plan.visibility_buffer && plan.shadow_maps && plan.acceleration_structures);
  EXPECT_TRUE(plan.shadow_mask && plan.compute_shading && plan.fxaa_only);
  EXPECT_FALSE(plan.hdr_samples || plan.forward || plan.tone_map);
  EXPECT_FALSE(plan.surface_planes || plan.inspection);
}

TEST(FramePlan, PlanesAloneNeedNoShading) {
  const FramePlan plan = plan_frame(lit_scene(), only(wire::kDepthF32), {});
  EXPECT_TRUE(plan.visibility_buffer && plan.surface_planes &&
              plan.camera_levels == CameraLevels::by_appearance);
  EXPECT_FALSE(plan.shading || plan.coverage_merge || plan.compute_shading || plan.forward);
  EXPECT_FALSE(plan.tone_map || plan.fxaa_only);
  EXPECT_FALSE(plan.shadows || plan.shadow_maps || plan.shadow_mask || plan.acceleration_structures);
}

TEST(FramePlan, LinearColoursLeaveToneMappingToShading) {
  FrameFacts facts = lit_scene();
  FramePlan plan = plan_frame(facts, only(wire::kColorLinearF16), {});
  EXPECT_TRUE(plan.compute_shading && plan.hdr_samples && plan.linear);
  EXPECT_FALSE(plan.tone_map || plan.forward || plan.fxaa_only || plan.surface_planes);
  facts.has_forward_only = true;
  plan = plan_frame(facts, only(wire::kColorLinearF16), {});
  EXPECT_TRUE(plan.compute_shading && plan.hdr_samples && plan.linear && plan.tone_map);
  facts.raster_path = settings::RasterPath::forward;
  plan = plan_frame(facts, only(wire::kColorLinearF16), {});
  EXPECT_TRUE(plan.linear && plan.tone_map);
  EXPECT_FALSE(plan.hdr_samples);
}

TEST(FramePlan, RayEffectsPrecedeShading) {
  FrameFacts facts = lit_scene();
  EXPECT_FALSE(plan_frame(facts, {}, {}).ray_effects);
  facts.ray_effects = true;
  facts.has_lights = facts.needs_shadow_maps = false;
  const FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.ray_effects && plan.acceleration_structures && plan.compute_shading);
  EXPECT_FALSE(plan_frame(facts, only(wire::kDepthF32), {}).ray_effects);
  EXPECT_FALSE(plan_frame(facts, {}, {}, 2).ray_effects);
  facts.raster_path = settings::RasterPath::forward;
  EXPECT_FALSE(plan_frame(facts, {}, {}).ray_effects);
  facts.raster_path = settings::RasterPath::visibility;
  facts.is_path_traced = true;
  EXPECT_FALSE(plan_frame(facts, {}, {}).ray_effects);
}

TEST(FramePlan, ForwardDrawsContinueSamples) {
  FrameFacts facts = lit_scene();
  facts.has_forward_only = true;
  FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.compute_shading && plan.hdr_samples && plan.forward && plan.tone_map);
  facts.can_write_samples = false;
  plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.forward && plan.tone_map && plan.acceleration_structures);
  EXPECT_FALSE(plan.compute_shading || plan.hdr_samples || plan.visibility_buffer || plan.shadow_mask);
}

TEST(FramePlan, MarkersDrawOverSamples) {
  FrameFacts facts = lit_scene();
  EXPECT_FALSE(plan_frame(facts, {}, {}).markers);
  facts.has_markers = true;
  FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.compute_shading && plan.hdr_samples && plan.forward && plan.markers && plan.tone_map);
  EXPECT_FALSE(plan_frame(facts, only(wire::kDepthF32), {}).markers);
  plan = plan_frame(facts, {}, {}, 2);
  EXPECT_FALSE(plan.markers || plan.hdr_samples) << "images of several views have none";
  EXPECT_TRUE(plan.compute_shading && plan.fxaa_only);
  facts.can_write_samples = false;
  plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.forward && plan.markers && plan.tone_map);
  EXPECT_FALSE(plan.compute_shading);
}

TEST(FramePlan, BloomReadsComputeSamples) {
  FrameFacts facts = lit_scene();
  EXPECT_FALSE(plan_frame(facts, {}, {}).bloom);
  facts.bloom = true;
  FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.bloom && plan.compute_shading && plan.hdr_samples && plan.tone_map);
  EXPECT_FALSE(plan.forward || plan.fxaa_only);
  EXPECT_FALSE(plan_frame(facts, only(wire::kColorLinearF16), {}).bloom) << "linear colours have none";
  EXPECT_FALSE(plan_frame(facts, only(wire::kDepthF32), {}).bloom);
  Inspection normals;
  normals.debug_view = settings::DebugView::normals;
  EXPECT_FALSE(plan_frame(facts, {}, normals).bloom);
  facts.can_write_samples = false;
  plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.bloom && plan.forward && plan.tone_map);
  EXPECT_FALSE(plan.compute_shading);
  facts.is_path_traced = true;
  plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.bloom && plan.path_resolve);
  EXPECT_FALSE(plan.shading || plan.tone_map);
}

TEST(FramePlan, SensorReplacesToneMapping) {
  FrameFacts facts = lit_scene();
  facts.has_mask = true;
  FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_FALSE(plan.sensor || plan.mask_planes || plan.hdr_samples);
  facts.has_optics = true;
  plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.sensor && plan.compute_shading && plan.hdr_samples && plan.tone_map);
  EXPECT_FALSE(plan.mask_planes) << "there are none";
  plan = plan_frame(facts, only(wire::kDepthF32), {});
  EXPECT_TRUE(plan.mask_planes);
  EXPECT_FALSE(plan.sensor || plan.hdr_samples) << "planes have no noise";
  facts.has_mask = false;  // with distortion, the lens pass applies it
  EXPECT_FALSE(plan_frame(facts, only(wire::kDepthF32), {}).mask_planes);
  facts.is_path_traced = true;
  plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.sensor && plan.path_resolve);
}

TEST(FramePlan, MeteringReadsComputeSamples) {
  FrameFacts facts = lit_scene();
  facts.metered = true;
  const FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.metering && plan.compute_shading && plan.hdr_samples && plan.tone_map);
  EXPECT_FALSE(plan.bloom || plan.fxaa_only);
  EXPECT_FALSE(plan_frame(facts, only(wire::kColorLinearF16), {}).metering);
}

TEST(FramePlan, DepthOfFieldReadsComputeSamples) {
  FrameFacts facts = lit_scene();
  EXPECT_FALSE(plan_frame(facts, {}, {}).depth_of_field);
  facts.depth_of_field = true;
  const FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.depth_of_field && plan.compute_shading && plan.hdr_samples && plan.tone_map);
  EXPECT_FALSE(plan.forward || plan.fxaa_only);
  EXPECT_TRUE(plan_frame(facts, only(wire::kColorLinearF16), {}).depth_of_field)
      << "the lens is part of the light";
  EXPECT_FALSE(plan_frame(facts, only(wire::kDepthF32), {}).depth_of_field);
  EXPECT_FALSE(plan_frame(facts, {}, {}, 2).depth_of_field);
}

TEST(FramePlan, ForwardPathHasNoVisibilityBuffer) {
  FrameFacts facts = lit_scene();
  facts.raster_path = settings::RasterPath::forward;
  FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.forward && plan.tone_map && plan.acceleration_structures);
  EXPECT_FALSE(plan.visibility_buffer || plan.shadow_mask || plan.compute_shading);
  facts.shadow_technique.back_end = settings::RayBackEnd::pipeline;
  plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.visibility_buffer && plan.shadow_mask && plan.forward);
  EXPECT_FALSE(plan.compute_shading || plan.camera_levels != CameraLevels::finest)
      << "forward draws use LOD 0 only";
}

TEST(FramePlan, NoShadowsBuildNothing) {
  FrameFacts facts = lit_scene();
  facts.has_lights = false;
  EXPECT_FALSE(plan_frame(facts, {}, {}).acceleration_structures);
  facts = lit_scene();
  facts.shadows_on = false;
  const FramePlan plan = plan_frame(facts, {}, {});
  EXPECT_TRUE(plan.compute_shading);
  EXPECT_FALSE(plan.shadows || plan.shadow_maps || plan.shadow_mask || plan.acceleration_structures);
}

TEST(FramePlan, DebugViewKeepsPlanes) {
  Inspection inspection;
  inspection.debug_view = settings::DebugView::normals;
  ImageOutputs outputs;
  outputs.add(wire::kInstanceU32);
  FramePlan plan = plan_frame(lit_scene(), outputs, inspection);
  EXPECT_TRUE(plan.visibility_buffer && plan.inspection && plan.surface_planes);
  EXPECT_FALSE(plan.shading || plan.shadows);
  inspection.debug_view = settings::DebugView::unresolved_shadows;
  plan = plan_frame(lit_scene(), outputs, inspection);
  EXPECT_TRUE(plan.shading && plan.shadow_mask) << "it marks pixels of the shaded image";
}

TEST(FramePlan, PathTracingReplacesShading) {
  FrameFacts facts = lit_scene();
  facts.is_path_traced = true;
  ImageOutputs outputs;
  outputs.add(wire::kDepthF32);
  const FramePlan plan = plan_frame(facts, outputs, {});
  EXPECT_TRUE(plan.path_resolve && plan.visibility_buffer && plan.surface_planes);
  EXPECT_FALSE(plan.shading || plan.compute_shading || plan.shadows || plan.acceleration_structures);
  EXPECT_FALSE(plan.hdr_samples || plan.forward || plan.tone_map || plan.fxaa_only);
  EXPECT_FALSE(plan_frame(facts, only(wire::kDepthF32), {}).path_resolve);
  EXPECT_FALSE(plan_frame(lit_scene(), outputs, {}).path_resolve);
}

TEST(FramePlan, SeveralViewsShadeInCompute) {
  const FramePlan plan = plan_frame(lit_scene(), {}, {}, 3);
  EXPECT_TRUE(plan.visibility_buffer && plan.compute_shading && plan.fxaa_only);
  EXPECT_FALSE(plan.forward || plan.tone_map);
  EXPECT_FALSE(plan_frame(lit_scene(), only(wire::kDepthF32), {}, 3).fxaa_only);
}

TEST(FramePlan, MapsUseCoarseLevelsEverywhere) {
  FrameFacts facts = lit_scene();
  EXPECT_FALSE(plan_frame(facts, {}, {}).shadow_map_levels_of_detail);
  facts.levels_of_detail = settings::LevelsOfDetail::everywhere;
  EXPECT_TRUE(plan_frame(facts, {}, {}).shadow_map_levels_of_detail);
  facts.levels_of_detail = settings::LevelsOfDetail::off;
  EXPECT_EQ(plan_frame(facts, {}, {}).camera_levels, CameraLevels::finest);
  facts.levels_of_detail = settings::LevelsOfDetail::surface;
  EXPECT_EQ(plan_frame(facts, {}, {}).camera_levels, CameraLevels::by_surface);
}

}  // namespace
}  // namespace fire3dv::passes
