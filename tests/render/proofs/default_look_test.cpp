// Render test of the default look: display-referred colours, the gradient, and the shadow catcher.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "renderer/scene/textures/environment.h"
#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

class DefaultLook : public ValidationIsSilent {};

constexpr VkExtent2D kExtent{96, 72};

float decode(int code) {
  const float s = static_cast<float>(code) / 255;
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}
int encode(float linear) {
  const float s = linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
  return static_cast<int>(std::lround(255 * s));
}

// An unlit wall; with_glass: beside a blended box, so that the image is drawn with forward-only draws.
scene::Scene unlit_wall(bool with_glass) {
  SceneBuilder builder;
  scene::Material orange = matte({1, decode(127), 0});
  orange.unlit = true;
  builder.mesh_node("wall", builder.quad(builder.material(orange), 2), glm::mat4(1));
  if (with_glass) {
    scene::Material glass = matte({0.2f, 0.4f, 0.9f});
    glass.alpha_mode = scene::AlphaMode::blend;
    glass.base_color.a = 0.5f;
    builder.mesh_node("glass", builder.box(builder.material(glass), {0.4f, 0.1f, 0.4f}), at({1.2f, 0.5f, 1}));
  }
  builder.camera_node("camera", {0, 6, 0}, {0, 0, 0});
  return builder.build();
}

// Unlit materials and plain backgrounds have the file's and the option's colours, whatever exposure and tone
// mapping are, on all raster paths.
TEST_F(DefaultLook, UnlitColoursAreExact) {
  for (const bool with_glass : {false, true}) {
    const scene::Scene scene = unlit_wall(with_glass);
    for (const settings::RasterPath path :
         {settings::RasterPath::visibility, settings::RasterPath::forward}) {
      for (const settings::ToneMap tone_map : {settings::ToneMap::neutral, settings::ToneMap::aces}) {
        settings::DrawSettings settings;
        settings.raster = path;
        settings.post = {.exposure = 2.5f, .tone_map = tone_map, .fxaa = false};
        settings.background.color = {decode(32), decode(160), decode(255)};
        RenderBench bench(scene, kExtent, settings);
        const sinks::FrameImage image = bench.draw_at_rest();
        const std::string where = std::string(with_glass ? "glass " : "") + std::to_string(int(path)) + " " +
                                  std::to_string(int(tone_map));
        EXPECT_EQ(pixel(image, 36, 30), glm::ivec3(255, 127, 0)) << where;
        EXPECT_EQ(pixel(image, 1, 1), glm::ivec3(32, 160, 255)) << where;
      }
    }
  }
}

TEST_F(DefaultLook, TheGradientFollowsTheElevation) {
  const scene::Scene scene = SceneBuilder().build();
  for (const settings::RasterPath path : {settings::RasterPath::visibility, settings::RasterPath::forward}) {
    settings::DrawSettings settings;
    settings.raster = path;
    settings.background = settings::Background::gradient();
    ProofBench bench(kExtent, settings);
    bench.show(scene);
    const glm::vec3 low = settings.background.color, high = *settings.background.zenith;
    EXPECT_EQ(pixel(bench.draw({0, 0, 0}, {0, -1, 0.001f}), 48, 36),
              glm::ivec3(encode(low.r), encode(low.g), encode(low.b)));
    EXPECT_EQ(pixel(bench.draw({0, 0, 0}, {0, 1, 0.001f}), 48, 36),
              glm::ivec3(encode(high.r), encode(high.g), encode(high.b)));
    const sinks::FrameImage level = bench.draw({0, 0, 0}, {0, 0, -1});
    // The horizon: smoothstep(-0.55, 0.45, 0) = 0.55^2 (3 - 2 * 0.55).
    const float t = 0.55f * 0.55f * (3 - 1.1f);
    EXPECT_NEAR(pixel(level, 48, 36).g, encode(low.g + t * (high.g - low.g)), 1);
    EXPECT_LT(pixel(level, 48, 4).g, pixel(level, 48, 68).g);
  }
}

// The sky of a scene is its background, in its own colours, and lights nothing.
TEST_F(DefaultLook, ScenesMayHaveASky) {
  SceneBuilder builder;
  builder.mesh_node("post", builder.box(builder.material(matte({0.5f, 0.5f, 0.5f})), {0.1f, 0.1f, 0.1f}),
                    at({0, 0, -2}));
  scene::Scene with = builder.build();
  const uint8_t red[4] = {200, 40, 20, 255}, blue[4] = {10, 60, 220, 255};
  scene::Image sky{"sky", 8, 64, {}};
  for (uint32_t row = 0; row < sky.height; ++row)
    for (uint32_t column = 0; column < sky.width; ++column)
      sky.rgba8.edit().insert(sky.rgba8.edit().end(), row < 32 ? red : blue, (row < 32 ? red : blue) + 4);
  const scene::Scene without = with;
  with.images.push_back(sky);
  with.textures.push_back({static_cast<uint32_t>(with.images.size() - 1), {}, true});
  with.sky_texture = static_cast<uint32_t>(with.textures.size() - 1);
  for (const settings::RasterPath path : {settings::RasterPath::visibility, settings::RasterPath::forward}) {
    settings::DrawSettings settings;
    settings.raster = path;
    settings.post.exposure = 2;
    settings.background = settings::Background::automatic();
    const auto draw = [&](const scene::Scene& scene, settings::Background background) {
      settings.background = background;
      ProofBench bench(kExtent, settings);
      bench.show(scene);
      return bench.draw({0, 0, 0}, {0, 0, -1});
    };
    const sinks::FrameImage image = draw(with, settings::Background::automatic());
    EXPECT_EQ(pixel(image, 8, 4), glm::ivec3(200, 40, 20));
    EXPECT_EQ(pixel(image, 8, 68), glm::ivec3(10, 60, 220));
    const sinks::FrameImage plain = draw(without, settings::Background::automatic());
    EXPECT_EQ(pixel(image, 48, 36), pixel(plain, 48, 36)) << "the post";
    EXPECT_EQ(draw(with, settings::Background::gradient()).rgba8, plain.rgba8);
    EXPECT_EQ(draw(without, settings::Background::gradient()).rgba8, plain.rgba8);
  }
}

// A box hovers above the plane; the sun shines straight down, so that its shadow is the box's outline.
TEST_F(DefaultLook, GroundShowsShadowsOnBackground) {
  SceneBuilder builder;
  builder.mesh_node("box", builder.box(builder.material(matte({0.5f, 0.5f, 0.5f})), {0.5f, 0.1f, 0.5f}),
                    at({0, 1, 0}));
  constexpr float kLux = 3;
  builder.light_node(sun({1, 1, 1}, kLux), shining_towards({0, -1, 0}));
  const scene::Scene scene = builder.build();
  const state::PoseState poses(scene);
  scene::Camera lens;
  const auto view_from = [&](const glm::vec3& eye, const glm::vec3& target) {
    return passes::make_view(lens, passes::look_at_pose(eye, target), 96.0f / 72);
  };
  for (const settings::RasterPath path : {settings::RasterPath::visibility, settings::RasterPath::forward}) {
    settings::DrawSettings settings;
    settings.raster = path;
    settings.post.fxaa = false;
    settings.background.color = glm::vec3(0.5f);
    settings.shadows = {path == settings::RasterPath::forward ? settings::ShadowMethod::map
                                                              : settings::ShadowMethod::automatic};
    // A uniform sky of radiance 1 gives the plane pi lux.
    settings.environment = std::make_shared<const scene::EnvironmentImage>(
        scene::make_environment(64, 32, [](const glm::vec3&) { return glm::vec3(1); }));
    RenderBench bench(scene, kExtent, settings);
    passes::View view = view_from({0, 0.6f, 4}, {0, 0, 0});
    const sinks::FrameImage without = bench.draw(poses, view);
    view.ground = scene::Ground{0, 20, {0, 0}};
    const bool has_planes = path == settings::RasterPath::visibility;
    const Taken with =
        bench.take(poses, view,
                   passes::ImageOutputs(has_planes ? wire::kColorSrgb8 | wire::kDepthF32 | wire::kInstanceU32
                                                   : wire::kColorSrgb8));
    EXPECT_EQ(pixel(without, 48, 36), glm::ivec3(encode(0.5f)));
    const float pi = 3.14159265f;
    EXPECT_NEAR(pixel(with.image, 48, 36).g, encode(0.5f * pi / (pi + kLux)), 2)
        << "the middle of the shadow";
    EXPECT_EQ(pixel(with.image, 5, 50), pixel(without, 5, 50)) << "outside of the shadow";
    EXPECT_EQ(pixel(with.image, 48, 2), pixel(without, 48, 2)) << "above the horizon";
    if (has_planes) {
      EXPECT_EQ(with.plane<uint32_t>(wire::kInstanceU32)[36 * 96 + 48], 0u) << "the ground is background";
      EXPECT_TRUE(std::isinf(with.plane<float>(wire::kDepthF32)[36 * 96 + 48]));
    }
    passes::View below = view_from({0, -0.6f, 4}, {0, 0.2f, 0});
    const sinks::FrameImage from_below = bench.draw(poses, below);
    below.ground = scene::Ground{0, 20, {0, 0}};
    EXPECT_EQ(bench.draw(poses, below).rgba8, from_below.rgba8) << "seen from below";
  }
}

// A post that stands on the ground; the sun shines towards +x and down by 45 degrees.
constexpr glm::vec3 kPostLow{-0.15f, 0, -0.15f}, kPostHigh{0.15f, 2, 0.15f};

scene::Scene post_on_ground(glm::vec3 color) {
  SceneBuilder builder;
  scene::Material material = matte(color);
  material.unlit = true;
  builder.mesh_node("post", builder.box(builder.material(material), 0.5f * (kPostHigh - kPostLow)),
                    at(0.5f * (kPostHigh + kPostLow)));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({1, -1, 0}));
  return builder.build();
}

bool meets_post(const glm::vec3& from, const glm::vec3& direction) {
  const glm::vec3 a = (kPostLow - from) / direction, b = (kPostHigh - from) / direction;
  const glm::vec3 enters = glm::min(a, b), leaves = glm::max(a, b);
  return std::max({enters.x, enters.y, enters.z, 0.0f}) < std::min({leaves.x, leaves.y, leaves.z});
}

enum class Shown { post, shadow, light, unclear };

// What an image position shows; unclear: within margin_m of the shadow's border.
Shown shown_at(const passes::View& view, glm::vec2 ndc, float margin_m) {
  const glm::vec3 ray =
      view.world_from_ndc_x * ndc.x + view.world_from_ndc_y * ndc.y + view.world_from_ndc_origin;
  if (meets_post(view.eye_world, ray)) return Shown::post;
  if (ray.y >= 0) return Shown::unclear;
  const glm::vec3 ground = view.eye_world - ray * (view.eye_world.y / ray.y);
  const glm::vec3 to_sun{-1, 1, 1e-6f};
  const bool is_shadow = meets_post(ground, to_sun);
  for (const glm::vec3 offset :
       {glm::vec3(margin_m, 0, 0), glm::vec3(0, 0, margin_m), glm::vec3(0, 0, -margin_m)}) {
    if (meets_post(ground + offset, to_sun) != is_shadow) return Shown::unclear;
  }
  return is_shadow ? Shown::shadow : Shown::light;
}

// No pixel between a black post and its shadow is brighter than the shadow, and none between a white post and
// the lit ground is darker than the ground.
TEST_F(DefaultLook, GroundShadowsTouchTheirBodies) {
  constexpr VkExtent2D kSize{160, 120};
  constexpr float kSky = 0.5f, kPi = 3.14159265f;
  const int dark = encode(kSky * kPi / (kPi + 3 * std::sqrt(0.5f))), bright = encode(kSky);
  for (const bool is_white : {false, true}) {
    const scene::Scene scene = post_on_ground(glm::vec3(is_white ? 1 : 0));
    for (const settings::RasterPath path :
         {settings::RasterPath::visibility, settings::RasterPath::forward}) {
      for (const uint32_t samples : {1u, 4u}) {
        settings::DrawSettings settings = shadowed_by(settings::ShadowMethod::map, false, samples);
        settings.raster = path;
        settings.background.color = glm::vec3(kSky);
        settings.environment_intensity = 1;
        settings.environment = std::make_shared<const scene::EnvironmentImage>(
            scene::make_environment(64, 32, [](const glm::vec3&) { return glm::vec3(1); }));
        RenderBench bench(scene, kSize, settings);
        passes::View view = passes::make_view(
            scene::Camera{},
            passes::look_at_pose(is_white ? glm::vec3(-1.2f, 1.1f, 1) : glm::vec3(1.2f, 1.1f, 1), {}),
            4.0f / 3);
        view.ground = scene::Ground{0, 20, {0, 0}};
        const sinks::FrameImage image = bench.draw(state::PoseState(scene), view);
        int edges = 0, wrong = 0;
        for (uint32_t y = 1; y + 1 < kSize.height; ++y) {
          for (uint32_t x = 1; x + 1 < kSize.width; ++x) {
            const Shown wanted = is_white ? Shown::light : Shown::shadow;
            bool near_post = false, others = false;
            for (int i = 0; i < 9; ++i) {
              const glm::vec2 at_px(static_cast<float>(x) + 0.75f * static_cast<float>(i % 3) - 0.25f,
                                    static_cast<float>(y) + 0.75f * static_cast<float>(i / 3) - 0.25f);
              const Shown shown =
                  shown_at(view, at_px / glm::vec2(kSize.width, kSize.height) * 2.0f - 1.0f, 0.05f);
              near_post = near_post || shown == Shown::post;
              others = others || (shown != Shown::post && shown != wanted);
            }
            if (!near_post || others) continue;
            ++edges;
            const int code = pixel(image, x, y).g;
            if (is_white ? code < bright - 2 : code > dark + 2) ++wrong;
          }
        }
        EXPECT_GT(edges, 20);
        EXPECT_EQ(wrong, 0) << (is_white ? "white " : "black ") << static_cast<int>(path) << ", " << samples
                            << " samples";
      }
    }
  }
}

}  // namespace
}  // namespace fire3dv::test
