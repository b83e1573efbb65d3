// Render test of the two raster paths: visibility and forward give the same image.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

class RasterPaths : public ValidationIsSilent {
 protected:
  static sinks::FrameImage drawn(const scene::Scene& scene, settings::RasterPath path, uint32_t samples,
                                 settings::ShadowMethod shadows = settings::ShadowMethod::off) {
    settings::DrawSettings settings;
    settings.raster = path;
    settings.samples = samples;
    settings.shadows.method = shadows;
    settings.post.fxaa = false;
    RenderBench bench(scene, {320, 240}, settings);
    return bench.draw_at_rest();
  }
  static void expect_same(const scene::Scene& scene) {
    for (uint32_t samples : {1u, 4u}) {
      SCOPED_TRACE(samples);
      const sinks::FrameImage forward = drawn(scene, settings::RasterPath::forward, samples);
      const sinks::FrameImage visibility = drawn(scene, settings::RasterPath::visibility, samples);
      EXPECT_TRUE(
          matches_image(visibility, forward, "raster_paths_" + std::to_string(samples), Tolerance::colour()));
    }
  }
};

// coat: adds an invisible object with clearcoat, which selects the shader for all materials.
scene::Scene shapes(bool coat = false) {
  SceneBuilder builder;
  builder.mesh_node("ground", builder.quad(builder.material(matte({0.6f, 0.6f, 0.6f})), 40), glm::mat4(1));
  builder.mesh_node("ball", builder.sphere(builder.material(matte({0.8f, 0.4f, 0.2f})), 0.6f),
                    at({0.8f, 0.6f, 0}));
  builder.mesh_node("fine", builder.sphere(builder.material(matte({0.2f, 0.6f, 0.8f})), 0.4f, 256),
                    at({-0.2f, 0.4f, 1}));
  builder.mesh_node("box", builder.box(builder.material(matte({0.3f, 0.8f, 0.3f})), {0.5f, 0.5f, 0.5f}),
                    at({-1, 0.5f, 0}) * glm::rotate(glm::mat4(1), 0.4f, glm::vec3(0, 1, 0)) *
                        glm::scale(glm::mat4(1), glm::vec3(-1, 1, 1)));
  if (coat) {
    scene::Material coated = matte({0.5f, 0.5f, 0.5f});
    coated.clearcoat = 1;
    builder.mesh_node("in the ball", builder.box(builder.material(coated), {0.1f, 0.1f, 0.1f}),
                      at({0.8f, 0.6f, 0}));
  }
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.5f, -1, -0.4f}));
  builder.camera_node("camera", {1.5f, 1.2f, 3.5f}, {0, 0.4f, 0});
  return builder.build();
}

TEST_F(RasterPaths, GroundPassesTheEye) {
  expect_same(shapes());
}

// A board with a fine texture, seen obliquely, and a smooth metal.
scene::Scene textured_shapes() {
  SceneBuilder builder;
  scene::Material board = matte({1, 1, 1});
  board.base_color_texture.texture = builder.texture(64, 64, true, [](float u, float v) {
    return glm::vec4(0.5f + 0.4f * std::sin(40 * u), 0.5f + 0.4f * std::sin(60 * v), 0.4f, 1);
  });
  scene::Material metal = matte({0.9f, 0.7f, 0.4f});
  metal.metallic = 1;
  metal.roughness = 0.3f;
  builder.mesh_node("board", builder.quad(builder.material(board), 4, 6), glm::mat4(1));
  builder.mesh_node("ball", builder.sphere(builder.material(metal), 0.5f, 48), at({0.3f, 0.5f, 0.4f}));
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.5f, -1, -0.4f}));
  builder.camera_node("camera", {1.5f, 1.2f, 3.5f}, {0, 0.4f, 0});
  return builder.build();
}

// Away from edges between bodies the paths differ by 2 of 255 at most. Where a shadow's border crosses a
// pixel of several triangles, they trace from other points of it (docs/design/visibility.md).
TEST_F(RasterPaths, PathsAgreeOffEdges) {
  constexpr VkExtent2D kExtent{320, 240};
  constexpr int kWidth = kExtent.width, kHeight = kExtent.height;
  for (const scene::Scene& scene : {shapes(), textured_shapes()}) {
    const state::PoseState poses(scene);
    for (const uint32_t samples : {1u, 4u}) {
      // Fine textures with 4 samples differ by more; see the document.
      if (samples == 4 && !scene.textures.empty()) continue;
      for (const auto shadows : {settings::ShadowMethod::off, settings::ShadowMethod::ray}) {
        SCOPED_TRACE(scene.nodes[0].name + ", samples " + std::to_string(samples) +
                     (shadows == settings::ShadowMethod::off ? "" : ", shadows"));
        settings::DrawSettings settings;
        settings.raster = settings::RasterPath::visibility;
        settings.samples = samples;
        settings.shadows.method = shadows;
        settings.post.fxaa = false;
        RenderBench bench(scene, kExtent, settings);
        const Taken seen = bench.take(poses, first_camera_view(scene, poses, kExtent),
                                      wire::ImageOutputs(wire::kColorSrgb8 | wire::kInstanceU32));
        const auto body = seen.plane<uint32_t>(wire::kInstanceU32);
        const sinks::FrameImage forward = drawn(scene, settings::RasterPath::forward, samples, shadows);
        size_t compared = 0, other = 0;
        for (int y = 1; y < kHeight - 1; ++y) {
          for (int x = 1; x < kWidth - 1; ++x) {
            bool is_edge = false;
            for (int i = 0; i < 9; ++i)
              is_edge |= body[(y + i / 3 - 1) * kWidth + x + i % 3 - 1] != body[y * kWidth + x];
            if (is_edge) continue;
            ++compared;
            const glm::ivec3 by = glm::abs(pixel(seen.image, x, y) - pixel(forward, x, y));
            other += std::max({by.r, by.g, by.b}) > 2 ? 1 : 0;
          }
        }
        EXPECT_GT(compared, size_t{60000});
        EXPECT_LE(other, shadows == settings::ShadowMethod::ray && samples == 4 ? compared / 1000 : 0);
      }
    }
  }
}

// Scenes with core glTF materials use a specialised shading shader (on CPU devices with another order of
// work). It must match the general one.
TEST_F(RasterPaths, CoreMaterialsMatchGeneralShading) {
  for (uint32_t samples : {1u, 4u}) {
    for (const settings::ShadowMethod shadows : {settings::ShadowMethod::off, settings::ShadowMethod::map}) {
      SCOPED_TRACE(std::to_string(samples) + (shadows == settings::ShadowMethod::map ? ", maps" : ""));
      const sinks::FrameImage core = drawn(shapes(), settings::RasterPath::visibility, samples, shadows);
      const sinks::FrameImage all = drawn(shapes(true), settings::RasterPath::visibility, samples, shadows);
      EXPECT_TRUE(matches_image(core, all, "core_materials_" + std::to_string(samples), Tolerance::colour()));
    }
  }
}

// Blended boxes at the centre, at the image's edge, far apart, out of view, and around the eye.
TEST_F(RasterPaths, ForwardOnlyDrawsAreVisible) {
  struct Case {
    std::vector<glm::vec3> places;
    float half_side_m;
    uint32_t samples;
    bool seen;
  };
  const std::vector<Case> cases = {{{{0, 0.5f, 1}, {0, 0.3f, 1.4f}}, 0.1f, 1, true},
                                   {{{-1.6f, 0.4f, 0.5f}, {-0.9f, 0.3f, 1}}, 0.2f, 4, true},
                                   {{{0, 0.5f, 6}, {0, 40, 0}}, 0.3f, 1, false},
                                   {{{1.3f, 1.1f, 3.2f}, {0, 40, 0}}, 0.6f, 1, true}};
  auto scene_with = [&](const std::vector<glm::vec3>& places, float half_side_m) {
    SceneBuilder builder;
    builder.mesh_node("ground", builder.quad(builder.material(matte({0.6f, 0.6f, 0.6f})), 40), glm::mat4(1));
    scene::Material glass = matte({0.9f, 0.1f, 0.1f});
    glass.alpha_mode = scene::AlphaMode::blend;
    glass.base_color.a = 0.5f;
    glass.double_sided = true;
    const uint32_t box = builder.box(builder.material(glass), glm::vec3(half_side_m));
    for (const glm::vec3& place : places) builder.mesh_node("glass", box, at(place));
    builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.5f, -1, -0.4f}));
    builder.camera_node("camera", {1.5f, 1.2f, 3.5f}, {0, 0.4f, 0});
    return builder.build();
  };
  for (const Case& test : cases) {
    SCOPED_TRACE(testing::Message() << "at " << test.places[0].x << ", " << test.places[0].y);
    const scene::Scene scene = scene_with(test.places, test.half_side_m);
    const sinks::FrameImage visibility = drawn(scene, settings::RasterPath::visibility, test.samples);
    EXPECT_TRUE(matches_image(visibility, drawn(scene, settings::RasterPath::forward, test.samples),
                              "raster_paths_on_top", Tolerance::colour()));
    uint32_t red = 0;
    for (uint32_t y = 0; y < 240; ++y) {
      for (uint32_t x = 0; x < 320; ++x) {
        const glm::ivec3 color = pixel(visibility, x, y);
        red += color.r > color.g + 40;
      }
    }
    EXPECT_EQ(red > 50, test.seen) << red << " pixels";
  }
}

}  // namespace
}  // namespace fire3dv::test
