// Render test of images in motion on a CPU: they are those of one sample and shadow maps alone, and images at
// rest are the same bytes as without them.
#include <gtest/gtest.h>

#include "renderer/scene/model/scene_edits.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kMotionExtent{120, 90};
constexpr uint32_t kMotionBall = 1, kMotionSun = 3;

// is_other: a further body, so that all numbers behind it differ.
scene::Scene room_in_motion(bool is_other = false) {
  SceneBuilder builder;
  builder.mesh_node("ground", builder.quad(builder.material(matte({0.6f, 0.6f, 0.6f})), 8), glm::mat4(1));
  builder.mesh_node("ball", builder.sphere(builder.material(matte({0.8f, 0.4f, 0.2f})), 0.5f, 24),
                    at({0.4f, 0.6f, 0}));
  builder.mesh_node("box", builder.box(builder.material(matte({0.2f, 0.5f, 0.8f})), {0.3f, 0.3f, 0.3f}),
                    at({-0.7f, 0.3f, 0.2f}));
  scene::Light soft = sun({1, 0.9f, 0.8f}, 2);
  soft.angular_radius_rad = 0.05f;  // by rays: without maps, but not in motion
  builder.light_node(soft, shining_towards({-0.6f, -1, -0.4f}));
  if (is_other)
    builder.mesh_node("late", builder.box(builder.material(matte({0.1f, 0.7f, 0.2f})), {0.2f, 0.4f, 0.2f}),
                      at({0, 0.4f, 0.9f}));
  builder.camera_node("camera", {0.8f, 1.6f, 3}, {0, 0.3f, 0});
  return builder.build();
}

settings::DrawSettings reduced_settings() {
  settings::DrawSettings settings;
  settings.samples = 1;
  settings.shadows.method = settings::ShadowMethod::map;
  return settings;
}

class MotionQuality : public ValidationIsSilent {
 protected:
  // A scene in a renderer with these settings.
  struct Drawn {
    explicit Drawn(const settings::DrawSettings& settings) : bench(scene, kMotionExtent, settings) {
      bench.renderer().set_edits(edits);
    }
    passes::View view() { return first_camera_view(scene, poses, kMotionExtent); }
    std::vector<uint8_t> still() { return bench.draw(poses, view()).rgba8; }
    std::vector<uint8_t> moving() {
      bench.set_in_motion(true);
      std::vector<uint8_t> image = still();
      bench.set_in_motion(false);
      return image;
    }
    void edit(scene::NodeEdits changes) { edits.set(scene, std::move(changes)); }

    const scene::Scene scene = room_in_motion(), other = room_in_motion(true);
    state::PoseState poses{scene};
    scene::SceneEdits edits;
    RenderBench bench;
  };
};

scene::NodeEdits without_ball_at_noon() {
  scene::NodeEdits edits;
  edits[kMotionBall].hidden = true;
  edits[kMotionSun].light = sun({1, 1, 1}, 3);
  return edits;
}

TEST_F(MotionQuality, MotionHasOneSampleAndMaps) {
  Drawn drawn({}), reduced(reduced_settings());
  ASSERT_TRUE(drawn.bench.renderer().reduces_motion());
  EXPECT_FALSE(reduced.bench.renderer().reduces_motion());
  const std::vector<uint8_t> at_rest = drawn.still();
  EXPECT_NE(drawn.moving(), at_rest);
  EXPECT_EQ(drawn.moving(), reduced.still());
  EXPECT_EQ(drawn.still(), at_rest);

  // Edits reach both kinds of images, whichever is drawn first.
  for (Drawn* const each : {&drawn, &reduced}) each->edit(without_ball_at_noon());
  EXPECT_EQ(drawn.moving(), reduced.still());
  Drawn unmoved({});
  unmoved.edit(without_ball_at_noon());
  EXPECT_EQ(drawn.still(), unmoved.still());
  for (Drawn* const each : {&drawn, &reduced}) each->edit({});
  EXPECT_EQ(drawn.still(), at_rest);
  EXPECT_EQ(drawn.moving(), reduced.still());

  // So do settings and another scene.
  for (Drawn* const each : {&drawn, &reduced})
    each->bench.change_settings([](settings::DrawSettings& settings) { settings.post.exposure = 0.5f; });
  EXPECT_EQ(drawn.moving(), reduced.still());
  for (Drawn* const each : {&drawn, &reduced}) {
    each->poses.set_scene(each->other);
    each->bench.renderer().set_scene(each->other);
    each->edit({});
  }
  EXPECT_EQ(drawn.moving(), reduced.still());
}

TEST_F(MotionQuality, DataAndChosenSettingsStay) {
  Drawn drawn({});
  const passes::ImageOutputs outputs(wire::kColorSrgb8 | wire::kInstanceU32);
  drawn.bench.set_in_motion(true);
  const Taken data = drawn.bench.take(drawn.poses, drawn.view(), outputs);
  drawn.bench.set_in_motion(false);
  EXPECT_EQ(data.image.rgba8, drawn.still());

  settings::DrawSettings full;
  full.motion_quality = settings::MotionQuality::full;
  Drawn unreduced(full);
  EXPECT_FALSE(unreduced.bench.renderer().reduces_motion());
  EXPECT_EQ(unreduced.moving(), drawn.still());
}

}  // namespace
}  // namespace fire3dv::test
