// Render test of frame generations: cluster targets keep depths of earlier frames, which must stay invisible.
// Images of moving bodies equal those of a renderer without earlier frames.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/passes/resources/targets.h"
#include "tests/render/support/proof_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

using settings::ShadowMethod;

constexpr VkExtent2D kExtent{96, 72};
constexpr int kFrames = 6;  // the target is cleared twice, with all four generations between

scene::Material see_through(scene::AlphaMode mode, float alpha) {
  scene::Material material = matte({0.3f, 0.8f, 0.4f});
  material.alpha_mode = mode;
  material.double_sided = true;
  material.base_color.a = alpha;
  return material;
}

// A ground below a visible sky, and bodies with large and small triangles, alpha-masked and blended ones.
scene::Scene yard(bool glass) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({0.8f, 0.8f, 0.8f}));
  scene::Material fence = see_through(scene::AlphaMode::mask, 1);
  fence.base_color_texture.texture = builder.texture(32, 32, true, [](float u, float v) {
    return glm::vec4(1, 1, 1, glm::fract(4 * u) > 0.5f && glm::fract(4 * v) > 0.5f ? 0 : 1);
  });
  builder.mesh_node("ground", builder.quad(white, 1.2f), glm::mat4(1));
  builder.mesh_node("ball", builder.sphere(white, 0.3f, 48), glm::mat4(1));
  builder.mesh_node("box", builder.box(white, {0.2f, 0.35f, 0.2f}), glm::mat4(1));
  builder.mesh_node("guest", builder.sphere(white, 0.1f, 24), glm::mat4(1));
  builder.mesh_node("fence", builder.quad(builder.material(fence), 0.3f), glm::mat4(1));
  if (glass) {
    const uint32_t pane = builder.material(see_through(scene::AlphaMode::blend, 0.5f));
    builder.mesh_node("pane", builder.quad(pane, 0.3f), glm::mat4(1));
  }
  builder.light_node(sun({1, 1, 1}, 1.5f), shining_towards({-0.5f, -1, 0.4f}));
  scene::Light lamp;
  lamp.intensity = 3;
  builder.light_node(lamp, at({0.2f, 1.6f, 0.5f}));
  builder.camera_node("camera", {0.6f, 1.3f, 2.2f}, {0, 0.3f, 0});
  return builder.build();
}

state::RestPose moved(const scene::Scene& scene, int frame) {
  state::RestPose pose = state::rest_pose(scene);
  float angle = 1.1f * static_cast<float>(frame);
  for (size_t n = 0; n < scene.nodes.size(); ++n) {
    const std::string& name = scene.nodes[n].name;
    // Visible in every other frame.
    if (name == "guest")
      pose.world_from_node[n] = pose.parent_from_node[n] = at({0, frame % 2 == 1 ? 0.1f : -9.0f, 0.3f});
    if (name != "ball" && name != "box" && name != "fence" && name != "pane") continue;
    angle += 1.5f;
    pose.world_from_node[n] = pose.parent_from_node[n] =
        at({0.8f * std::cos(angle), 0.5f + 0.2f * std::sin(2 * angle), 0.8f * std::sin(angle)}) *
        glm::rotate(glm::mat4(1), angle, glm::normalize(glm::vec3(1, 0.3f, 0.2f)));
  }
  return pose;
}

wire::ImageOutputs with_planes() {
  wire::ImageOutputs outputs;
  outputs.add(wire::kDepthF32);
  outputs.add(wire::kInstanceU32);
  return outputs;
}

struct Case {
  uint32_t samples;
  ShadowMethod shadows;
  bool hybrid, glass;
};
class Generations : public ValidationIsSilent, public ::testing::WithParamInterface<Case> {};

TEST_P(Generations, EarlierDrawsAreInvisible) {
  const Case& c = GetParam();
  const scene::Scene scene = yard(c.glass);
  settings::DrawSettings settings = shadowed_by(c.shadows, c.hybrid, c.samples);
  settings.cull = settings::Cull::hidden;
  const wire::ImageOutputs outputs = with_planes();
  state::PoseState poses(scene);
  const passes::View view = first_camera_view(scene, poses, kExtent);
  RenderBench bench(scene, kExtent, settings);
  Taken last;
  for (int frame = 0; frame < kFrames; ++frame) {
    SCOPED_TRACE(frame);
    poses.set_rest(moved(scene, frame));
    const Taken taken = bench.take(poses, view, outputs);
    RenderBench fresh(scene, kExtent, settings);
    const Taken expected = fresh.take(poses, view, outputs);
    EXPECT_TRUE(matches_image(taken.image, expected.image, "generations", Tolerance::exact()));
    EXPECT_EQ(taken.plane<uint32_t>(wire::kDepthF32), expected.plane<uint32_t>(wire::kDepthF32));
    EXPECT_EQ(taken.plane<uint32_t>(wire::kInstanceU32), expected.plane<uint32_t>(wire::kInstanceU32));
    EXPECT_NE(taken.image.rgba8, last.image.rgba8) << "nothing moves";
    last = taken;
  }
}
INSTANTIATE_TEST_SUITE_P(Ways, Generations,
                         ::testing::Values(Case{1, ShadowMethod::map, false, true},
                                           Case{4, ShadowMethod::map, false, false},
                                           Case{1, ShadowMethod::ray, true, false},
                                           Case{4, ShadowMethod::ray, true, true},
                                           Case{4, ShadowMethod::ray, false, false}));

// A body whose scale overflows its vertices to infinity or NaN leaves no trace in later frames.
TEST_P(Generations, NanIsGoneInNextFrame) {
  const Case& c = GetParam();
  const scene::Scene scene = yard(c.glass);
  const settings::DrawSettings settings = shadowed_by(c.shadows, c.hybrid, c.samples);
  state::PoseState poses(scene);
  const passes::View view = first_camera_view(scene, poses, kExtent);
  RenderBench bench(scene, kExtent, settings), fresh(scene, kExtent, settings);
  const sinks::FrameImage expected = fresh.take(poses, view, {}).image;
  for (const float size : {1e19f, 1e30f, 3e38f}) {
    for (int before = 0; before < 4; ++before) {
      SCOPED_TRACE(testing::Message() << size << ", generation " << before);
      state::RestPose vast = state::rest_pose(scene);
      for (size_t n = 0; n < scene.nodes.size(); ++n) {
        if (scene.nodes[n].mesh != scene::kNone && scene.nodes[n].name != "ground")
          vast.world_from_node[n] = vast.parent_from_node[n] =
              glm::rotate(glm::mat4(1), 0.7f, glm::vec3(0.6f, 0.8f, 0)) *
              glm::scale(glm::mat4(1), glm::vec3(size));
      }
      poses.set_rest(vast);
      (void)bench.take(poses, view, {});
      poses.set_rest(state::rest_pose(scene));
      for (int i = 0; i < 4; ++i)
        EXPECT_TRUE(matches_image(bench.take(poses, view, {}).image, expected, "generations_vast",
                                  Tolerance::exact()));
    }
  }
}

TEST(ClusterTargets, GenerationOverflowClearsTargets) {
  passes::ClusterTarget target;
  std::vector<bool> emptied;
  std::vector<uint32_t> generations;
  const auto draw = [&](VkDeviceSize bytes) {
    target.begin(bytes);
    emptied.push_back(target.needs_clear());
    generations.push_back(target.generation());
  };
  for (int i = 0; i < 5; ++i) draw(100);
  EXPECT_EQ(emptied, (std::vector<bool>{true, false, false, false, true}));
  EXPECT_EQ(generations, (std::vector<uint32_t>{0, 0x40000000, 0x80000000, 0xc0000000, 0}));
  emptied.clear();
  for (VkDeviceSize bytes : {60, 100, 101, 100, 60, 60, 60, 101}) draw(bytes);
  EXPECT_EQ(emptied, (std::vector<bool>{false, false, true, false, false, false, true, true}));
}

}  // namespace
}  // namespace fire3dv::test
