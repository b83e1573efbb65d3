// Render test of the stale overlay: images of stale streams have a striped border and a badge, and images of
// live streams stay unchanged.
#include <gtest/gtest.h>

#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

using state::Condition;

class StaleOverlay : public ValidationIsSilent {};

constexpr uint32_t kWidth = 320, kHeight = 200;

scene::Scene wall(float light) {
  SceneBuilder builder;
  scene::Material material = matte({0, 0, 0});
  material.unlit = true;
  material.base_color = glm::vec4(light, light, light, 1);
  builder.mesh_node("wall", builder.quad(builder.material(material), 50), glm::mat4(1));
  builder.camera_node("camera", {0, 5, 0}, {0, 0, 0});
  return builder.build();
}

sinks::FrameImage drawn(const scene::Scene& scene, Condition condition, bool fxaa = true) {
  settings::DrawSettings settings;
  settings.post.fxaa = fxaa;
  RenderBench bench(scene, {kWidth, kHeight}, settings);
  bench.set_condition(condition);
  return bench.draw_at_rest();
}

TEST_F(StaleOverlay, FrameAndBadgeLeaveRest) {
  for (const float light : {0.0f, 0.5f, 1.0f}) {
    const scene::Scene scene = wall(light);
    const sinks::FrameImage live = drawn(scene, Condition::live);
    for (const bool fxaa : {true, false}) {
      for (const Condition condition : {Condition::late, Condition::lost}) {
        const sinks::FrameImage held = drawn(scene, condition, fxaa);
        uint32_t on_edge = 0, inside = 0, in_corner = 0;
        for (uint32_t y = 0; y < kHeight; ++y) {
          for (uint32_t x = 0; x < kWidth; ++x) {
            const uint32_t to_edge = std::min({x, y, kWidth - 1 - x, kHeight - 1 - y});
            const bool corner = x > kWidth - 40 && y < 40;
            const glm::ivec3 change = glm::abs(pixel(held, x, y) - pixel(live, x, y));
            const bool changed = std::max({change.r, change.g, change.b}) > 60;
            if (to_edge < 2)
              on_edge += changed;
            else
              (corner ? in_corner : inside) += changed;
          }
        }
        EXPECT_GT(on_edge, (kWidth + kHeight) * 4 * 2 / 5) << light << ": a half of the stripes or more";
        EXPECT_GT(in_corner, 100u) << light;
        EXPECT_EQ(inside, 0u) << light;
      }
    }
  }
}

TEST_F(StaleOverlay, LateAndLostLookUnlike) {
  const scene::Scene scene = wall(0.5f);
  EXPECT_TRUE(matches_golden(drawn(scene, Condition::late), "held_late", Tolerance::exact()));
  EXPECT_TRUE(matches_golden(drawn(scene, Condition::lost), "held_lost", Tolerance::exact()));
}

TEST_F(StaleOverlay, OnePixelImageIsMarked) {
  const scene::Scene scene = wall(0.5f);
  RenderBench bench(scene, {1, 1});
  bench.set_condition(Condition::lost);
  const glm::ivec3 color = pixel(bench.draw_at_rest(), 0, 0);
  EXPECT_NE(color.r, color.g);
}

}  // namespace
}  // namespace fire3dv::test
