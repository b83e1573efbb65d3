// Render test of scene sizes: lights, nodes, textures and cameras have no fixed maximum.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

class Many : public ValidationIsSilent {};

// 64 spot lights with disjoint cones on the ground: all 64 spots are bright, the gaps dark.
TEST_F(Many, SixtyFourLights) {
  SceneBuilder builder;
  builder.mesh_node("ground", builder.quad(builder.material(matte({0.8f, 0.8f, 0.8f})), 10), glm::mat4(1));
  for (int i = 0; i < 64; ++i) {
    scene::Light light;
    light.type = scene::LightType::spot;
    light.intensity = 30;
    light.inner_cone_rad = 0.15f;
    light.outer_cone_rad = 0.2f;
    builder.light_node(light, shining_towards({0, -1, 0}, {static_cast<float>(i % 8) - 3.5f, 2,
                                                           static_cast<float>(i / 8) - 3.5f}));
  }
  builder.camera_node("camera", {0, 40, 0}, {0, 0, 0}, 2 * std::atan(0.1f));  // sees 8 m x 8 m
  settings::DrawSettings settings;
  settings.environment_intensity = 0;
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, {160, 160}, settings);
  const sinks::FrameImage image = bench.draw_at_rest();
  for (uint32_t i = 0; i < 64; ++i) {
    const uint32_t x = (i % 8) * 20 + 10, y = (i / 8) * 20 + 10;
    EXPECT_GT(pixel(image, x, y).r, 150) << "light " << i;
    EXPECT_EQ(pixel(image, (i % 8) * 20, (i / 8) * 20), glm::ivec3(0)) << "between the lights, " << i;
  }
}

// A valid file may contain nothing to draw.
TEST_F(Many, AnEmptySceneIsItsBackground) {
  SceneBuilder builder;
  builder.camera_node("camera", {0, 1, 5}, {0, 0, 0});
  const scene::Scene with_camera = builder.build();
  const sinks::FrameImage image = RenderBench(with_camera, {32, 24}).draw_at_rest();
  for (uint32_t i = 0; i < 32 * 24; ++i) EXPECT_EQ(pixel(image, i % 32, i / 32), pixel(image, 0, 0));

  const scene::Scene nothing = SceneBuilder().build();
  const state::PoseState poses(nothing);
  const sinks::FrameImage also = RenderBench(nothing, {32, 24}).draw(poses, passes::View{});
  EXPECT_EQ(also.rgba8, image.rgba8);
}

// 10,000 nodes in a grid, each moved by a stream: each appears at its pose.
TEST_F(Many, TenThousandMovingNodes) {
  constexpr uint32_t kSide = 100;
  SceneBuilder builder;
  scene::Material bright = matte({0.9f, 0.9f, 0.9f});
  bright.unlit = true;
  const uint32_t tile = builder.quad(builder.material(bright), 0.5f);
  wire::StreamDescription description;
  description.epoch = 7;
  std::vector<wire::Affine3x4> poses;
  for (uint32_t i = 0; i < kSide * kSide; ++i) {
    const std::string name = "node_" + std::to_string(i);
    builder.mesh_node(name, tile, at({0, -1000, 0}));
    description.node_names.push_back(name);
    wire::Affine3x4 pose;
    // A checkerboard: every other tile lies outside of the view.
    const bool visible = (i % kSide + i / kSide) % 2 == 0;
    pose.m[3] = static_cast<float>(i % kSide) - 49.5f;
    pose.m[7] = visible ? 0.0f : -1000.0f;
    pose.m[11] = static_cast<float>(i / kSide) - 49.5f;
    poses.push_back(pose);
  }
  builder.camera_node("camera", {0, 500, 0}, {0, 0, 0}, 2 * std::atan(0.1f));  // sees 100 m x 100 m
  const scene::Scene scene = builder.build();
  state::PoseState state(scene);
  const state::StreamId stream = state.add_stream(description);
  wire::PoseFrameView frame;
  frame.header = {7, 1, 0, 0, 0, 0};
  frame.node_count = kSide * kSide;
  frame.poses = poses;
  ASSERT_TRUE(state.push(stream, frame));

  constexpr VkExtent2D kExtent{kSide * 2, kSide * 2};
  settings::DrawSettings settings;
  settings.post.fxaa = false;  // FXAA would soften a checkerboard of 2 x 2 pixel tiles
  settings.background.color = glm::vec3(0);
  RenderBench bench(scene, kExtent, settings);
  const sinks::FrameImage image = bench.draw(state, first_camera_view(scene, state, kExtent));
  uint32_t right = 0;
  for (uint32_t i = 0; i < kSide * kSide; ++i) {
    const bool visible = (i % kSide + i / kSide) % 2 == 0;
    // The centre of a tile of 2 x 2 pixels is the corner of four pixels; each of them is in the tile.
    const int seen = pixel(image, (i % kSide) * 2, (i / kSide) * 2).r;
    right += visible == (seen > 200);  // most of the pixel's samples show a tile
  }
  EXPECT_EQ(right, kSide * kSide);
}

// A pose may mirror a body, and a body mirrored at rest may get a pose without mirroring: both show front
// faces.
TEST_F(Many, MirroredPosesShowTheOutside) {
  for (const bool mirrored_at_rest : {false, true}) {
    SceneBuilder builder;
    scene::Material bright = matte({0.9f, 0.9f, 0.9f});
    bright.unlit = true;
    glm::mat4 rest(1);
    if (mirrored_at_rest) rest[0] = -rest[0];
    builder.mesh_node("tile", builder.quad(builder.material(bright), 1), rest);
    builder.camera_node("camera", {0, 5, 0}, {0, 0, 0});
    const scene::Scene scene = builder.build();
    state::PoseState state(scene);
    wire::StreamDescription description;
    description.epoch = 9;
    description.node_names = {"tile"};
    const state::StreamId stream = state.add_stream(description);
    RenderBench bench(scene, {16, 16});
    EXPECT_GT(pixel(bench.draw(state, first_camera_view(scene, state, {16, 16})), 8, 8).r, 170) << "at rest";
    for (uint64_t sequence = 1; sequence <= 4; ++sequence) {
      wire::Affine3x4 pose;
      pose.m[0] = sequence % 2 ? -1.0f : 1.0f;
      wire::PoseFrameView frame;
      frame.header.epoch = 9;
      frame.header.sequence = sequence;
      frame.node_count = 1;
      frame.poses = {&pose, 1};
      ASSERT_TRUE(state.push(stream, frame));
      EXPECT_GT(pixel(bench.draw(state, first_camera_view(scene, state, {16, 16})), 8, 8).r, 170) << sequence;
    }
  }
}

TEST_F(Many, HundredsOfTextures) {
  SceneBuilder builder;
  constexpr uint32_t kSide = 20;
  for (uint32_t i = 0; i < kSide * kSide; ++i) {
    const glm::vec3 color(static_cast<float>(i % kSide) / kSide, static_cast<float>(i / kSide) / kSide, 0.5f);
    scene::Material material = matte({1, 1, 1});
    material.unlit = true;
    material.base_color_texture.texture =
        builder.texture(4, 4, false, [=](float, float) { return glm::vec4(color, 1); });
    builder.mesh_node("tile_" + std::to_string(i), builder.quad(builder.material(material), 0.5f),
                      at({static_cast<float>(i % kSide) - 9.5f, 0, static_cast<float>(i / kSide) - 9.5f}));
  }
  builder.camera_node("camera", {0, 100, 0}, {0, 0, 0}, 2 * std::atan(0.1f));
  settings::DrawSettings settings;
  settings.post.tone_map = settings::ToneMap::none;
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, {kSide * 5, kSide * 5}, settings);
  const sinks::FrameImage image = bench.draw_at_rest();
  auto encoded = [](float linear) {
    return 255 * (linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f);
  };
  for (uint32_t i = 0; i < kSide * kSide; ++i) {
    const glm::ivec3 seen = pixel(image, (i % kSide) * 5 + 2, (i / kSide) * 5 + 2);
    ASSERT_NEAR(seen.r, encoded(std::round(255.0f * static_cast<float>(i % kSide) / kSide) / 255), 2)
        << "texture " << i;
    ASSERT_NEAR(seen.g, encoded(std::round(255.0f * static_cast<float>(i / kSide) / kSide) / 255), 2)
        << "texture " << i;
  }
}

}  // namespace
}  // namespace fire3dv::test
