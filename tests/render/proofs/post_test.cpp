// Render test of post-processing: tone mapping against its formulas, FXAA against a supersampled reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

class Post : public ValidationIsSilent {};

float encode(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

// An emissive wall that fills the image.
glm::ivec3 shown(glm::vec3 light, settings::ToneMap tone_map, float saturation = 1,
                 settings::RasterPath raster = settings::RasterPath::automatic) {
  SceneBuilder builder;
  scene::Material material = matte({0, 0, 0});
  material.emissive = light;
  builder.mesh_node("wall", builder.quad(builder.material(material), 10), glm::mat4(1));
  builder.camera_node("camera", {0, 5, 0}, {0, 0, 0});
  settings::DrawSettings settings;
  settings.environment_intensity = 0;
  settings.post.tone_map = tone_map;
  settings.post.saturation = saturation;
  settings.raster = raster;
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, {8, 8}, settings);
  return pixel(bench.draw_at_rest(), 4, 4);
}

TEST_F(Post, ToneMapsFollowTheirFormulas) {
  for (const float light : {0.02f, 0.18f, 0.5f, 1.0f, 4.0f}) {
    EXPECT_NEAR(shown(glm::vec3(light), settings::ToneMap::reinhard).g, 255 * encode(light / (1 + light)),
                1.1f)
        << light;
    EXPECT_NEAR(shown(glm::vec3(light), settings::ToneMap::none).g, 255 * encode(std::min(light, 1.0f)), 1.1f)
        << light;
    // Neutral: grey below the shoulder is reduced only by its Fresnel offset.
    const float offset = light < 0.08f ? light - 6.25f * light * light : 0.04f;
    float neutral = light - offset;
    if (neutral >= 0.76f) neutral = 1 - 0.24f * 0.24f / (neutral + 0.24f - 0.76f);
    EXPECT_NEAR(shown(glm::vec3(light), settings::ToneMap::neutral).g, 255 * encode(neutral), 1.1f) << light;
    // ACES: its matrices map grey to grey within rounding, so only the curve remains.
    const float curve =
        (light * (light + 0.0245786f) - 0.000090537f) / (light * (0.983729f * light + 0.432951f) + 0.238081f);
    EXPECT_NEAR(shown(glm::vec3(light), settings::ToneMap::aces).g, 255 * encode(std::min(curve, 1.0f)), 1.6f)
        << light;
  }
}

// ACES 1.0 shows a grey card of 18 % at 4.8 of 48 cd/m2. Contrast: slope of the curve of logarithms.
TEST_F(Post, AcesIsAFilmLikeCurve) {
  const auto grey = [](float light) {
    const float encoded = static_cast<float>(shown(glm::vec3(light), settings::ToneMap::aces).g) / 255;
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
  };
  const float middle = grey(0.18f);
  EXPECT_NEAR(middle, 4.8f / 48, 0.008f);
  const auto contrast = [&](float from, float to) {
    return std::log2(grey(to) / grey(from)) / std::log2(to / from);
  };
  EXPECT_LT(grey(0.04f) / 0.04f, 0.5f * middle / 0.18f) << "the toe";
  EXPECT_GT(contrast(0.09f, 0.18f), 1.4f);
  EXPECT_LT(contrast(1, 4), 0.35f) << "the shoulder";
  EXPECT_EQ(grey(30), 1);
}

TEST_F(Post, ToneMapsDifferInColour) {
  const glm::vec3 bright_red(6, 0.3f, 0.2f);
  EXPECT_GT(shown(bright_red, settings::ToneMap::none).r, 250);
  // Neutral desaturates overexposed colours; Reinhard per channel desaturates red less.
  const glm::ivec3 neutral = shown(bright_red, settings::ToneMap::neutral);
  EXPECT_GT(neutral.g, shown(glm::vec3(0.6f, 0.03f, 0.02f), settings::ToneMap::neutral).g);
  EXPECT_NE(neutral, shown(bright_red, settings::ToneMap::aces));
  EXPECT_NE(neutral, shown(bright_red, settings::ToneMap::reinhard));
}

TEST_F(Post, SaturationScalesTheDistanceFromGrey) {
  const glm::vec3 light(0.5f, 0.2f, 0.1f);
  const float grey = glm::dot(light, glm::vec3(0.2126f, 0.7152f, 0.0722f));
  for (const settings::RasterPath raster : {settings::RasterPath::automatic, settings::RasterPath::forward}) {
    for (const float saturation : {0.0f, 0.5f, 1.0f, 1.5f}) {
      const glm::ivec3 color = shown(light, settings::ToneMap::none, saturation, raster);
      for (int c = 0; c < 3; ++c) {
        const float expected = std::clamp(grey + saturation * (light[c] - grey), 0.0f, 1.0f);
        EXPECT_NEAR(color[c], 255 * encode(expected), 1.1f) << saturation << " channel " << c;
      }
    }
  }
}

scene::Scene slanted_shapes() {
  SceneBuilder builder;
  for (int i = 0; i < 5; ++i) {
    scene::Material material = matte({0, 0, 0});
    material.unlit = true;
    material.double_sided = true;
    material.base_color = glm::vec4(i % 2 ? 0.9f : 0.3f, 0.7f, i % 3 ? 0.2f : 0.8f, 1);
    builder.mesh_node("tile_" + std::to_string(i), builder.quad(builder.material(material), 0.55f),
                      glm::rotate(at({1.2f * static_cast<float>(i - 2), 0.1f * static_cast<float>(i), 0}),
                                  0.17f + 0.31f * static_cast<float>(i), glm::vec3(0, 1, 0)));
  }
  builder.camera_node("camera", {0, 8, 0}, {0, 0, 0}, 0.5f);
  return builder.build();
}

TEST_F(Post, FxaaKeepsFlatRegions) {
  constexpr uint32_t kWidth = 200, kHeight = 120, kFiner = 8;
  const scene::Scene scene = slanted_shapes();
  settings::DrawSettings settings;
  settings.samples = 1;
  settings.post.fxaa = false;
  const sinks::FrameImage plain = RenderBench(scene, {kWidth, kHeight}, settings).draw_at_rest();
  const sinks::FrameImage fine =
      RenderBench(scene, {kWidth * kFiner, kHeight * kFiner}, settings).draw_at_rest();
  settings.post.fxaa = true;
  const sinks::FrameImage smoothed = RenderBench(scene, {kWidth, kHeight}, settings).draw_at_rest();

  double error_plain = 0, error_smoothed = 0;
  uint32_t flat = 0, flat_changed = 0, edges = 0;
  for (uint32_t y = 1; y + 1 < kHeight; ++y) {
    for (uint32_t x = 1; x + 1 < kWidth; ++x) {
      bool uniform = true;
      for (uint32_t ny = y - 1; ny <= y + 1; ++ny) {
        for (uint32_t nx = x - 1; nx <= x + 1; ++nx) uniform &= pixel(plain, nx, ny) == pixel(plain, x, y);
      }
      if (uniform) {
        ++flat;
        flat_changed += pixel(smoothed, x, y) != pixel(plain, x, y);
        continue;
      }
      ++edges;
      glm::vec3 sum(0);
      for (uint32_t i = 0; i < kFiner * kFiner; ++i) {
        sum += glm::vec3(pixel(fine, x * kFiner + i % kFiner, y * kFiner + i / kFiner));
      }
      const glm::vec3 reference = sum / static_cast<float>(kFiner * kFiner);
      error_plain += glm::distance(glm::vec3(pixel(plain, x, y)), reference);
      error_smoothed += glm::distance(glm::vec3(pixel(smoothed, x, y)), reference);
    }
  }
  EXPECT_GT(edges, 500u);
  EXPECT_GT(flat, 10000u);
  EXPECT_EQ(flat_changed, 0u);
  RecordProperty("edge_error_ratio", std::to_string(error_smoothed / error_plain));
  EXPECT_LT(error_smoothed, 0.75 * error_plain) << error_smoothed / error_plain;
}

// A pattern with periods of 13 and 11 pixels, so that copies fall at different places of a workgroup.
TEST_F(Post, FxaaIsSameWhereverPixelLies) {
  constexpr uint32_t kRight = 13, kDown = 11, kWidth = 8 * kRight, kHeight = 8 * kDown;
  SceneBuilder builder;
  std::vector<uint32_t> tiles;
  for (const float light : {0.9f, 0.3f}) {
    scene::Material material = matte({0, 0, 0});
    material.unlit = true;
    material.double_sided = true;
    material.base_color = glm::vec4(glm::vec3(light), 1);
    tiles.push_back(builder.quad(builder.material(material), 1));
  }
  for (int x = 0; x < 8; ++x) {
    for (int z = 0; z < 8; ++z) {
      const glm::mat4 cell =
          at({13.0f * static_cast<float>(x) - 45.5f, 0, 11.0f * static_cast<float>(z) - 38.5f});
      for (size_t i = 0; i < tiles.size(); ++i) {
        const glm::mat4 place = glm::rotate(cell * at({i ? 2.3f : -2.1f, 0.5f * static_cast<float>(i), 0.7f}),
                                            i ? 1.1f : 0.23f, glm::vec3(0, 1, 0));
        builder.mesh_node("tile_" + std::to_string((x * 8 + z) * 2 + static_cast<int>(i)), tiles[i],
                          glm::scale(place, glm::vec3(i ? 2.2f : 3.1f)));
      }
    }
  }
  const scene::Scene scene = builder.build();
  scene::Camera camera;
  camera.orthographic = true;
  camera.half_extent_m = {kWidth / 2.0f, kHeight / 2.0f};  // one pixel for each metre
  settings::DrawSettings settings = plain_settings();
  const auto image_of = [&](bool fxaa) {
    settings.post.fxaa = fxaa;
    ProofBench bench({kWidth, kHeight}, settings);
    bench.show(scene);
    return bench.draw(camera, passes::look_at_pose({0, 10, 0}, {0, 0, 0}));
  };
  const sinks::FrameImage plain = image_of(false), smoothed = image_of(true);
  uint32_t changed = 0;
  for (uint32_t y = kDown; y < kHeight - 2 * kDown; ++y) {
    for (uint32_t x = kRight; x < kWidth - 2 * kRight; ++x) {
      for (const auto& [next_x, next_y] : {std::pair(x + kRight, y), std::pair(x, y + kDown)}) {
        ASSERT_EQ(pixel(plain, x, y), pixel(plain, next_x, next_y)) << "the pattern does not repeat";
        // The sampling position has a rounding error.
        ASSERT_NEAR(pixel(smoothed, x, y).g, pixel(smoothed, next_x, next_y).g, 1) << x << ", " << y;
      }
      changed += pixel(smoothed, x, y) != pixel(plain, x, y);
    }
  }
  EXPECT_GT(changed, 500u);
}

}  // namespace
}  // namespace fire3dv::test
