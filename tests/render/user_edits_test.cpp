// Render test of a viewer's edits: changed materials and settings equal a scene and a renderer built that
// way, and withdrawn changes restore the image byte for byte.
#include <gtest/gtest.h>

#include "renderer/scene/model/scene_edits.h"
#include "renderer/scene/textures/environment.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kEditsExtent{120, 90};

// Material indices; 0 is the default material.
constexpr uint32_t kClay = 1, kLeaf = 2, kGround = 3;

scene::Scene garden() {
  SceneBuilder builder;
  const uint32_t holes = builder.texture(
      16, 16, true, [](float u, float v) { return glm::vec4(0.3f, 0.7f, 0.2f, 0.2f + 0.8f * u * v); });
  const uint32_t bumps = builder.texture(16, 16, false, [](float u, float) {
    return glm::vec4(0.5f + 0.3f * (u < 0.5f ? 1.0f : -1.0f), 0.5f, 0.9f, 1);
  });
  builder.material(matte({0.6f, 0.5f, 0.4f}));
  scene::Material leaf = matte({1, 1, 1});
  leaf.base_color_texture.texture = holes;
  leaf.alpha_mode = scene::AlphaMode::mask;
  leaf.double_sided = true;
  builder.material(leaf);
  scene::Material ground = matte({0.7f, 0.7f, 0.7f});
  ground.normal_texture.texture = bumps;
  builder.material(ground);
  const uint32_t ball = builder.sphere(kClay, 0.5f, 32);
  builder.mesh_node("ground", builder.quad(kGround, 5, 6), glm::mat4(1));
  builder.mesh_node("ball", ball, at({-0.7f, 0.5f, 0}));
  builder.mesh_node("twin", ball, at({0.7f, 0.5f, 0}));
  builder.mesh_node("leaf", builder.quad(kLeaf, 0.8f), at({0, 1.4f, 0}));
  builder.light_node(sun({1, 0.9f, 0.8f}, 2), shining_towards({-0.4f, -1, -0.5f}));
  builder.camera_node("camera", {0.5f, 3, 3.5f}, {0, 0.5f, 0});
  return builder.build();
}

scene::MaterialEdits some_edits(const scene::Scene& scene) {
  scene::MaterialEdits edits;
  scene::MaterialFactors clay = scene::factors_of(scene.materials[kClay]);
  clay.base_color = {0.9f, 0.3f, 0.1f, 1};
  clay.metallic = 0.8f;
  clay.roughness = 0.25f;
  clay.emissive = {0, 0.05f, 0.1f};
  edits[kClay] = clay;
  scene::MaterialFactors leaf = scene::factors_of(scene.materials[kLeaf]);
  leaf.alpha_cutoff = 0.4f;
  edits[kLeaf] = leaf;
  scene::MaterialFactors ground = scene::factors_of(scene.materials[kGround]);
  ground.normal_scale = 0.3f;
  edits[kGround] = ground;
  return edits;
}

scene::Scene made_so(scene::Scene scene, const scene::MaterialEdits& edits) {
  for (const auto& [number, factors] : edits)
    scene.materials[number] = scene::with_factors(scene.materials[number], factors);
  return scene;
}

class Wishes : public ValidationIsSilent, public ::testing::WithParamInterface<settings::RasterPath> {};

TEST_P(Wishes, EditedMaterialsLookAsLoadedOnes) {
  settings::DrawSettings settings;
  settings.raster = GetParam();
  const scene::Scene scene = garden();
  const state::PoseState poses(scene);
  scene::SceneEdits edits;
  RenderBench bench(scene, kEditsExtent, settings);
  bench.renderer().set_edits(edits);
  const passes::View view = first_camera_view(scene, poses, kEditsExtent);
  const auto draw = [&] { return bench.draw(poses, view).rgba8; };
  const std::vector<uint8_t> as_loaded = draw();

  const scene::MaterialEdits all = some_edits(scene);
  edits.set_materials(all);
  const std::vector<uint8_t> edited = draw();
  EXPECT_NE(edited, as_loaded);
  // A node with its own colour takes the other factors of the edited material, and keeps the colour on
  // changes.
  scene::NodeEdits colored;
  colored[2].base_color = glm::vec4(0.1f, 0.2f, 0.9f, 1);
  ASSERT_EQ(scene.nodes[2].name, "twin");
  edits.set(scene, colored);
  const std::vector<uint8_t> edited_and_colored = draw();
  scene::MaterialEdits smoother = all;
  smoother[kClay].roughness = 0.1f;
  edits.set_materials(smoother);
  const std::vector<uint8_t> smoother_and_colored = draw();
  edits.set(scene, {});
  const std::vector<uint8_t> smooth = draw();
  edits.set_materials({{1000, {}}});
  EXPECT_EQ(draw(), as_loaded);
  edits.set_materials({});
  EXPECT_EQ(draw(), as_loaded);

  // Both kinds of edit, in a scene that is new to the GPU.
  edits.set(scene, colored);
  edits.set_materials(smoother);
  bench.renderer().set_scene(scene);
  EXPECT_EQ(draw(), smoother_and_colored);
  edits.set(scene, {});
  edits.set_materials({});
  const scene::Scene loaded_so = made_so(scene, all), loaded_smooth = made_so(scene, smoother);
  bench.renderer().set_scene(loaded_so);
  EXPECT_EQ(draw(), edited);
  edits.set(loaded_so, colored);
  EXPECT_EQ(draw(), edited_and_colored);
  edits.set(scene, {});
  bench.renderer().set_scene(loaded_smooth);
  EXPECT_EQ(draw(), smooth);
  edits.set(loaded_smooth, colored);
  EXPECT_EQ(draw(), smoother_and_colored);
}

INSTANTIATE_TEST_SUITE_P(Paths, Wishes,
                         ::testing::Values(settings::RasterPath::visibility, settings::RasterPath::forward));

class Settings : public ValidationIsSilent {};

TEST_F(Settings, AppliedSettingsMatchNewRenderer) {
  const scene::Scene scene = garden();
  const settings::DrawSettings first;
  settings::DrawSettings wanted;
  wanted.post = {.exposure = 0.6f, .tone_map = settings::ToneMap::aces, .fxaa = false};
  wanted.cull = settings::Cull::off;
  wanted.levels_of_detail = settings::LevelsOfDetail::off;
  wanted.shadows.method = settings::ShadowMethod::off;
  wanted.environment_intensity = 0.4f;
  wanted.environment_rotation_rad = 1;
  wanted.background.show_environment = false;
  wanted.background.color = {0.1f, 0.2f, 0.4f};

  RenderBench bench(scene, kEditsExtent, first);
  const std::vector<uint8_t> before = bench.draw_at_rest().rgba8;
  EXPECT_FALSE(bench.renderer().needs_new_renderer(wanted));
  bench.renderer().apply(wanted);
  const std::vector<uint8_t> applied = bench.draw_at_rest().rgba8;
  EXPECT_NE(applied, before);
  EXPECT_FALSE(bench.renderer().needs_new_renderer(first));
  bench.renderer().apply(first);
  EXPECT_EQ(bench.draw_at_rest().rgba8, before);
  EXPECT_EQ(RenderBench(scene, kEditsExtent, wanted).draw_at_rest().rgba8, applied);
}

TEST_F(Settings, WhatNeedsAnotherRendererIsSaid) {
  const scene::Scene scene = garden();
  const settings::DrawSettings first;
  RenderBench bench(scene, kEditsExtent, first);
  const auto needs = [&](const std::function<void(settings::DrawSettings&)>& change) {
    settings::DrawSettings wanted = first;
    change(wanted);
    return bench.renderer().needs_new_renderer(wanted);
  };
  EXPECT_FALSE(needs([](settings::DrawSettings&) {}));
  EXPECT_FALSE(needs([](settings::DrawSettings& s) { s.raster = settings::RasterPath::visibility; }));
  EXPECT_TRUE(needs([](settings::DrawSettings& s) { s.raster = settings::RasterPath::forward; }));
  EXPECT_TRUE(needs([](settings::DrawSettings& s) { s.samples = 1; }));
  EXPECT_TRUE(needs([](settings::DrawSettings& s) { s.anisotropy = 4; }));
  EXPECT_TRUE(needs([](settings::DrawSettings& s) { s.shadows.method = settings::ShadowMethod::map; }));
  EXPECT_TRUE(needs([](settings::DrawSettings& s) { s.shadows.hybrid = false; }));
  EXPECT_FALSE(needs([](settings::DrawSettings& s) { s.shadows.method = settings::ShadowMethod::off; }));
  EXPECT_TRUE(needs([](settings::DrawSettings& s) { s.max_textures *= 2; }));
  EXPECT_TRUE(needs([](settings::DrawSettings& s) {
    s.environment = std::make_shared<scene::EnvironmentImage>(scene::studio_environment());
  }));

  // Unavailable settings return an error message.
  EXPECT_TRUE(bench.renderer().can_inspect().ok());
  EXPECT_TRUE(bench.renderer().can_show(settings::DebugView::unresolved_shadows).ok());
  settings::DrawSettings maps = first;
  maps.shadows.method = settings::ShadowMethod::map;
  RenderBench with_maps(scene, kEditsExtent, maps);
  EXPECT_TRUE(with_maps.renderer().can_show(settings::DebugView::overdraw).ok());
  const Result<void> unresolved = with_maps.renderer().can_show(settings::DebugView::unresolved_shadows);
  ASSERT_FALSE(unresolved.ok());
  EXPECT_NE(unresolved.error().message.find("shadow maps"), std::string::npos) << unresolved.error().message;
  settings::DrawSettings forward = first;
  forward.raster = settings::RasterPath::forward;
  RenderBench drawn_forward(scene, kEditsExtent, forward);
  const Result<void> inspect = drawn_forward.renderer().can_inspect();
  ASSERT_FALSE(inspect.ok());
  EXPECT_NE(inspect.error().message.find("--raster forward"), std::string::npos) << inspect.error().message;
  EXPECT_FALSE(drawn_forward.renderer().can_show(settings::DebugView::normals).ok());
  EXPECT_TRUE(drawn_forward.renderer().can_show(settings::DebugView::none).ok());
}

}  // namespace
}  // namespace fire3dv::test
