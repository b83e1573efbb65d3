// Render test of blended surfaces: each pixel composites its layers in the order of their depths, held
// against closed forms. Colours are unlit, so that a pixel is a sum of the layers' colours times their
// alphas.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kSize{65, 49};
constexpr glm::vec3 kBehind(0.25f, 0.5f, 0.75f);  // background, display-referred

scene::Material glass(glm::vec3 color, float alpha, bool double_sided = true) {
  scene::Material material = matte(color);
  material.unlit = true;
  material.alpha_mode = scene::AlphaMode::blend;
  material.base_color.a = alpha;
  material.double_sided = double_sided;
  return material;
}

class Transparency : public ValidationIsSilent, public testing::WithParamInterface<settings::RasterPath> {
 protected:
  static settings::DrawSettings settings() {
    settings::DrawSettings settings;
    settings.raster = GetParam();
    settings.post.fxaa = false;
    settings.background.color = kBehind;
    return settings;
  }
  static sinks::FrameImage draw(SceneBuilder& builder) {
    builder.camera_node("camera", {0, 0, 3}, {0, 0, 0});
    const scene::Scene scene = builder.build();
    return RenderBench(scene, kSize, settings()).draw_at_rest();
  }
};

INSTANTIATE_TEST_SUITE_P(Paths, Transparency,
                         testing::Values(settings::RasterPath::visibility, settings::RasterPath::forward),
                         [](const auto& test) {
                           return test.param == settings::RasterPath::forward ? "forward" : "visibility";
                         });

struct Layer {
  glm::vec3 color;
  float alpha;
};

// near_to_far over the background.
glm::vec3 light_of(const std::vector<Layer>& near_to_far) {
  glm::vec3 light(0);
  float passed = 1;
  for (const Layer& layer : near_to_far) {
    light += passed * layer.alpha * layer.color;
    passed *= 1 - layer.alpha;
  }
  return light + passed * kBehind;
}

glm::ivec3 encoded(const glm::vec3& light) {
  glm::ivec3 srgb;
  for (int c = 0; c < 3; ++c) {
    const float value =
        light[c] <= 0.0031308f ? 12.92f * light[c] : 1.055f * std::pow(light[c], 1 / 2.4f) - 0.055f;
    srgb[c] = static_cast<int>(std::lround(255 * value));
  }
  return srgb;
}

// In 8-bit sRGB.
glm::ivec3 composited(const std::vector<Layer>& near_to_far) {
  return encoded(light_of(near_to_far));
}

testing::AssertionResult is_near(const glm::ivec3& color, const glm::ivec3& expected, int levels = 1) {
  const glm::ivec3 off = glm::abs(color - expected);
  if (std::max({off.r, off.g, off.b}) <= levels) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "(" << color.r << ", " << color.g << ", " << color.b
                                     << ") instead of (" << expected.r << ", " << expected.g << ", "
                                     << expected.b << ")";
}

const glm::vec3 kRed(0.9f, 0.1f, 0.1f), kBlue(0.1f, 0.1f, 0.9f), kYellow(0.9f, 0.8f, 0.1f);

glm::mat4 facing_camera(float z) {
  return glm::rotate(at({0, 0, z}), glm::radians(90.0f), glm::vec3(1, 0, 0));
}

TEST_P(Transparency, DoubleSidedBodyShowsItsFarSideThroughTheNearOne) {
  SceneBuilder builder;
  builder.mesh_node("ball", builder.sphere(builder.material(glass(kRed, 0.5f)), 0.7f), at({0, 0, 0}));
  const sinks::FrameImage image = draw(builder);
  const glm::ivec3 expected = composited({{kRed, 0.5f}, {kRed, 0.5f}});
  for (uint32_t y = 16; y <= 32; ++y)
    for (uint32_t x = 24; x <= 40; ++x) EXPECT_TRUE(is_near(pixel(image, x, y), expected)) << x << ", " << y;
}

// A shell around a ball with the same centre: three orders of draws give one image.
TEST_P(Transparency, NestedShellsAreCompositedByDepth) {
  struct Shell {
    float radius_m;
    Layer layer;
  };
  const std::array<Shell, 3> shells{{{0.8f, {kYellow, 0.3f}}, {0.6f, {kRed, 0.6f}}, {0.4f, {kBlue, 0.9f}}}};
  std::vector<Layer> layers;
  for (const Shell& shell : shells) layers.push_back(shell.layer);
  for (size_t i = shells.size(); i-- > 0;) layers.push_back(shells[i].layer);
  for (const std::array<size_t, 3>& order : {std::array<size_t, 3>{0, 1, 2}, {2, 1, 0}, {1, 2, 0}}) {
    SceneBuilder builder;
    for (const size_t i : order)
      builder.mesh_node("shell",
                        builder.sphere(builder.material(glass(shells[i].layer.color, shells[i].layer.alpha)),
                                       shells[i].radius_m),
                        at({0, 0, 0}));
    const sinks::FrameImage image = draw(builder);
    for (uint32_t y = 20; y <= 28; ++y)
      for (uint32_t x = 28; x <= 36; ++x)
        EXPECT_TRUE(is_near(pixel(image, x, y), composited(layers))) << x << ", " << y;
  }
}

// Two sheets that cross in the vertical line through the centre: each is in front on one side. They belong to
// one mesh, or to two nodes.
TEST_P(Transparency, CrossingSheetsAreInFrontOnOneSideEach) {
  for (const bool is_one_mesh : {true, false}) {
    SCOPED_TRACE(is_one_mesh ? "one mesh" : "two nodes");
    SceneBuilder builder;
    const auto corners = [](float slope) {
      return std::vector<glm::vec3>{{-1, -1, -slope}, {1, -1, slope}, {1, 1, slope}, {-1, 1, -slope}};
    };
    const std::vector<uint32_t> two{0, 1, 2, 0, 2, 3};
    std::vector<glm::vec3> colors{kRed, kBlue};
    if (is_one_mesh) {
      colors[1] = kRed;
      std::vector<glm::vec3> positions = corners(0.5f);
      const std::vector<glm::vec3> others = corners(-0.5f);
      positions.insert(positions.end(), others.begin(), others.end());
      builder.mesh_node("cross",
                        builder.triangles(builder.material(glass(kRed, 0.6f)), positions,
                                          {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7}),
                        glm::mat4(1));
    } else {
      builder.mesh_node("right", builder.triangles(builder.material(glass(kRed, 0.6f)), corners(0.5f), two),
                        glm::mat4(1));
      builder.mesh_node("left", builder.triangles(builder.material(glass(kBlue, 0.6f)), corners(-0.5f), two),
                        glm::mat4(1));
    }
    const sinks::FrameImage image = draw(builder);
    const glm::ivec3 right = composited({{colors[0], 0.6f}, {colors[1], 0.6f}});
    const glm::ivec3 left = composited({{colors[1], 0.6f}, {colors[0], 0.6f}});
    // Of the pixel where they cross, two samples lie on each side.
    const glm::ivec3 middle = encoded(0.5f * (light_of({{colors[0], 0.6f}, {colors[1], 0.6f}}) +
                                              light_of({{colors[1], 0.6f}, {colors[0], 0.6f}})));
    for (uint32_t y = 16; y <= 32; ++y) {
      EXPECT_TRUE(is_near(pixel(image, 32, y), middle, 2));
      EXPECT_TRUE(is_near(pixel(image, 40, y), right));
      EXPECT_TRUE(is_near(pixel(image, 34, y), right));
      EXPECT_TRUE(is_near(pixel(image, 24, y), left));
      EXPECT_TRUE(is_near(pixel(image, 30, y), left));
    }
  }
}

std::vector<Layer> sheets(uint32_t count, float alpha) {
  std::vector<Layer> layers;
  for (uint32_t i = 0; i < count; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(count);
    layers.push_back({{share, 1 - share, i % 2 ? 0.8f : 0.2f}, alpha});
  }
  return layers;
}

// In an order of nodes and of materials that is not that of depths.
void add_sheets(SceneBuilder& builder, const std::vector<Layer>& near_to_far) {
  const auto count = static_cast<uint32_t>(near_to_far.size());
  for (uint32_t k = 0; k < count; ++k) {
    const uint32_t i = 7 * k % count;
    builder.mesh_node("sheet",
                      builder.quad(builder.material(glass(near_to_far[i].color, near_to_far[i].alpha)), 0.5f),
                      facing_camera(-0.02f * static_cast<float>(i)));
  }
}

// Of pixels off the diagonals, where each sheet has one fragment.
TEST_P(Transparency, ManySheetsInAnyOrderAreExact) {
  for (const uint32_t count : {6u, 20u, 31u}) {
    SceneBuilder builder;
    const std::vector<Layer> layers = sheets(count, 0.15f);
    add_sheets(builder, layers);
    const sinks::FrameImage image = draw(builder);
    EXPECT_TRUE(is_near(pixel(image, 36, 22), composited(layers), 2)) << count << " sheets";
    EXPECT_TRUE(is_near(pixel(image, 28, 23), composited(layers), 2)) << count << " sheets";
  }
}

// Behind the 32 nearest layers of a pixel the rest is merged: its transmittance is exact, its colour the
// mean.
TEST_P(Transparency, LayersBehindTheNearestAreMerged) {
  SceneBuilder builder;
  std::vector<Layer> layers = sheets(41, 0.05f);
  add_sheets(builder, layers);
  glm::vec3 mean(0);
  for (size_t i = 32; i < layers.size(); ++i)
    mean += layers[i].color / static_cast<float>(layers.size() - 32);
  for (size_t i = 32; i < layers.size(); ++i) layers[i].color = mean;
  EXPECT_TRUE(is_near(pixel(draw(builder), 36, 22), composited(layers), 2));
}

TEST_P(Transparency, AlmostOpaqueBodyLooksLikeAnOpaqueOne) {
  const auto body = [](float alpha) {
    SceneBuilder builder;
    scene::Material material = glass(kRed, alpha);
    material.unlit = false;
    builder.mesh_node("ball", builder.sphere(builder.material(material), 0.8f), glm::mat4(1));
    builder.mesh_node("core", builder.sphere(builder.material(glass(kYellow, 1)), 0.4f), glm::mat4(1));
    builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.5f, -1, -0.8f}));
    return draw(builder);
  };
  const sinks::FrameImage opaque = body(1), almost = body(0.99f);
  for (uint32_t y = 0; y < kSize.height; ++y)
    for (uint32_t x = 0; x < kSize.width; ++x)
      EXPECT_TRUE(is_near(pixel(almost, x, y), pixel(opaque, x, y), 4)) << x << ", " << y;
}

TEST_P(Transparency, OpaqueSurfaceHidesLayersBehindIt) {
  SceneBuilder builder;
  scene::Material wall = glass(kYellow, 1);
  wall.alpha_mode = scene::AlphaMode::opaque;
  builder.mesh_node("near", builder.quad(builder.material(glass(kRed, 0.4f)), 0.5f), facing_camera(0.5f));
  builder.mesh_node("wall", builder.quad(builder.material(wall), 0.5f), facing_camera(0));
  builder.mesh_node("far", builder.quad(builder.material(glass(kBlue, 0.4f)), 0.5f), facing_camera(-0.5f));
  EXPECT_TRUE(is_near(pixel(draw(builder), 32, 24), composited({{kRed, 0.4f}, {kYellow, 1}})));
}

TEST_P(Transparency, MarkersAndSurfacesVeilEachOther) {
  SceneBuilder builder;
  builder.mesh_node("near", builder.quad(builder.material(glass(kRed, 0.4f)), 0.5f), facing_camera(0.5f));
  builder.mesh_node("far", builder.quad(builder.material(glass(kBlue, 0.4f)), 0.5f), facing_camera(-0.5f));
  builder.camera_node("camera", {0, 0, 3}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, kSize, settings());
  for (const uint32_t alpha : {0x80u, 0xffu}) {
    wire::Marker marker;
    marker.kind = wire::MarkerKind::triangles;
    marker.positions = {{-0.5f, -0.5f, 0}, {0.5f, -0.5f, 0}, {0, 0.6f, 0}};
    marker.colors = {alpha << 24 | 0x00ff00};
    const std::vector<state::ShownMarker> shown{
        {alpha, std::make_shared<const wire::Marker>(marker), glm::mat4(1)}};
    bench.set_markers(&shown);
    const Layer green{{0, 1, 0}, static_cast<float>(alpha) / 255};
    EXPECT_TRUE(
        is_near(pixel(bench.draw_at_rest(), 32, 24), composited({{kRed, 0.4f}, green, {kBlue, 0.4f}})));
  }
}

// Without rays a volume absorbs along its thickness, in world units, and reflects at its far side, too.
TEST_P(Transparency, VolumeAbsorbsAlongItsThickness) {
  const auto light_behind = [](float thickness) {
    SceneBuilder builder;
    scene::Material volume = matte({1, 1, 1});
    volume.transmission = 1;
    volume.roughness = 0;
    volume.thickness = thickness;
    volume.attenuation_color = {0.6f, 0.9f, 0.7f};
    volume.attenuation_distance_m = 0.6f;
    builder.mesh_node("glass", builder.quad(builder.material(volume), 0.5f),
                      facing_camera(0) * glm::scale(glm::mat4(1), glm::vec3(2)));
    builder.camera_node("camera", {0, 0, 3}, {0, 0, 0});
    const scene::Scene scene = builder.build();
    settings::DrawSettings dark = settings();
    dark.environment_intensity = 0;
    dark.post.tone_map = settings::ToneMap::none;
    const glm::vec3 srgb = glm::vec3(pixel(RenderBench(scene, kSize, dark).draw_at_rest(), 32, 24)) / 255.0f;
    return glm::vec3(std::pow((srgb.r + 0.055f) / 1.055f, 2.4f), std::pow((srgb.g + 0.055f) / 1.055f, 2.4f),
                     std::pow((srgb.b + 0.055f) / 1.055f, 2.4f));
  };
  const glm::vec3 wall = light_behind(0), body = light_behind(0.25f);
  const float lengths = 2 * 0.25f / 0.6f, passed = 1 - 0.04f;
  EXPECT_NEAR(body.r / wall.r, passed * std::pow(0.6f, lengths), 0.02);
  EXPECT_NEAR(body.g / wall.g, passed * std::pow(0.9f, lengths), 0.02);
  EXPECT_NEAR(body.b / wall.b, passed * std::pow(0.7f, lengths), 0.02);
}

// Fragments arrive in any order: two images of small triangles that overlap have the same bytes, alone and
// after another image.
TEST_P(Transparency, ImagesRepeat) {
  SceneBuilder builder;
  for (int i = 0; i < 5; ++i)
    builder.mesh_node("ball",
                      builder.sphere(builder.material(glass(i % 2 ? kRed : kBlue, 0.3f)),
                                     0.5f + 0.02f * static_cast<float>(i), 96),
                      at({0.1f * static_cast<float>(i), 0, 0}));
  builder.camera_node("camera", {0, 0, 3}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, kSize, settings());
  const sinks::FrameImage first = bench.draw_at_rest();
  EXPECT_EQ(bench.draw_at_rest().rgba8, first.rgba8);
  bench.set_size({32, 20});
  (void)bench.draw_at_rest();
  bench.set_size(kSize);
  EXPECT_EQ(bench.draw_at_rest().rgba8, first.rgba8);
  EXPECT_EQ(RenderBench(scene, kSize, settings()).draw_at_rest().rgba8, first.rgba8);
}

}  // namespace
}  // namespace fire3dv::test
