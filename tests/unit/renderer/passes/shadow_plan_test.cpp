// Test of shadow plans for many lights: sums do not wrap, and lights beyond the memory limit cast no shadow.
#include "renderer/passes/shadows/shadow_plan.h"

#include <gtest/gtest.h>

namespace fire3dv::passes {
namespace {

std::vector<scene::PlacedLight> point_lights(uint32_t count) {
  std::vector<scene::PlacedLight> lights(count);
  for (uint32_t i = 0; i < count; ++i) lights[i].node = i;
  return lights;
}

TEST(ShadowPlan, FewLightsHaveAllMaps) {
  const ShadowPlan plan = plan_shadows(point_lights(8), 4, true, {});
  EXPECT_EQ(plan.views.size(), 48u);
  EXPECT_EQ(plan.mask_words, 1u);
  EXPECT_EQ(plan.lights_without_shadow, 0u);
  EXPECT_LE(plan.texels, uint64_t{48} << 20);
}

// 87,500 point lights have 525,000 maps of two times 64 x 64 texels: beyond 32 bits.
TEST(ShadowPlan, MapsStayWithinBudget) {
  const ShadowLimits limits;
  const ShadowPlan plan = plan_shadows(point_lights(87'500), 4, true, {}, limits);
  EXPECT_LE(plan.texels, limits.max_texels);
  EXPECT_GT(plan.lights_without_shadow, 80'000u);
  uint64_t end = 0;
  for (const gpu_types::LightViewRequest& view : plan.views) {
    EXPECT_EQ(view.first_texel, end);
    end += uint64_t{plan.sizes.maps_of_view} * view.size * view.size;
  }
  EXPECT_EQ(end, plan.texels);
  for (const gpu_types::LightShadow& shadow : plan.shadows) {
    ASSERT_LE(shadow.first_view + shadow.view_count, plan.views.size());
    ASSERT_EQ(shadow.rays == 0, shadow.mask_word == FIRE3DV_NO_INDEX);
  }
}

std::vector<scene::PlacedLight> suns(uint32_t count) {
  std::vector<scene::PlacedLight> lights = point_lights(count);
  for (scene::PlacedLight& placed : lights) placed.light.type = scene::LightType::directional;
  return lights;
}

// The share of one of 4,096 worlds holds eight maps of 64 x 64 texels.
TEST(ShadowPlan, SmallMapsCountAsTheyAre) {
  ShadowLimits limits;
  limits.max_texels /= 4096;
  for (const uint32_t side : {64u, 128u}) {
    const ShadowPlan plan = plan_shadows(suns(3), 1, false, {side, 1}, limits);
    EXPECT_EQ(plan.lights_without_shadow, 0u);
    ASSERT_EQ(plan.views.size(), 3u);
    EXPECT_EQ(plan.views[0].size, side) << "there is room for the whole maps";
  }
  EXPECT_EQ(plan_shadows(suns(9), 1, false, {64, 1}, limits).lights_without_shadow, 1u);
}

TEST(ShadowPlan, MapsShrinkBeforeLightsLoseThem) {
  std::vector<scene::PlacedLight> lights = suns(2);
  lights.push_back(point_lights(1)[0]);
  ShadowLimits limits;
  limits.max_fitted_texels = UINT32_MAX / 4096;
  const ShadowPlan plan = plan_shadows(lights, 1, false, {2048, 1}, limits);
  EXPECT_EQ(plan.lights_without_shadow, 0u);
  ASSERT_EQ(plan.views.size(), 8u);
  EXPECT_EQ(plan.views[0].size, 512u);
  EXPECT_EQ(plan.views[2].size, 256u) << "a cube face has half the side";
  EXPECT_LE(plan.texels, limits.max_fitted_texels);
  // Not below the smallest size.
  limits.max_fitted_texels = 1;
  EXPECT_EQ(plan_shadows(lights, 1, false, {2048, 1}, limits).views[0].size, 64u);
}

TEST(ShadowPlan, MasksAndViewsAreLimited) {
  ShadowLimits limits;
  limits.max_mask_words = 2;
  ShadowPlan plan = plan_shadows(point_lights(100), 4, true, {}, limits);
  EXPECT_EQ(plan.mask_words, 2u);
  EXPECT_EQ(plan.mask_words_wanted, 13u);
  EXPECT_EQ(plan.lights_without_shadow, 84u);
  limits = {};
  limits.max_views = 13;
  plan = plan_shadows(point_lights(100), 4, true, {}, limits);
  EXPECT_EQ(plan.views.size(), 12u);
  EXPECT_EQ(plan.lights_without_shadow, 98u);
  limits = {};
  limits.has_memory = false;
  plan = plan_shadows(point_lights(3), 4, true, {}, limits);
  EXPECT_TRUE(plan.views.empty());
  EXPECT_EQ(plan.lights_without_shadow, 3u);
  EXPECT_EQ(plan.mask_words, 1u);
}

}  // namespace
}  // namespace fire3dv::passes
