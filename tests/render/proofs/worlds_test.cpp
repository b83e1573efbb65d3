// Render test of several worlds of one scene in one submission: each view is bit-identical to one of a scene
// with its world alone.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/render/support/bent_bar.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kWorldExtent{48, 40};
constexpr uint32_t kWorlds = 3;

// A mirror image, an alpha-masked sheet and a floor of large triangles under a lamp that hangs on a body.
scene::Scene swinging_scene() {
  SceneBuilder builder;
  scene::Material sieve = matte({0.9f, 0.8f, 0.2f});
  sieve.alpha_mode = scene::AlphaMode::mask;
  sieve.double_sided = true;
  sieve.base_color_texture.texture = builder.texture(16, 16, true, [](float u, float v) {
    return glm::vec4(1, 1, 1, std::fmod(u * 4, 1.0f) < 0.5f || std::fmod(v * 4, 1.0f) < 0.5f ? 1 : 0);
  });
  builder.mesh_node("floor", builder.quad(builder.material(matte({0.5f, 0.6f, 0.7f})), 20), glm::mat4(1));
  builder.mesh_node("ball", builder.sphere(builder.material(matte({0.8f, 0.2f, 0.2f})), 0.6f, 64),
                    at({0, 0.7f, 0}));
  builder.mesh_node("sieve", builder.quad(builder.material(sieve), 6),
                    at({-1, 1, -1}) * glm::rotate(glm::mat4(1), 1.2f, glm::vec3(1, 0, 0.3f)));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-1, -2, -0.5f}));
  builder.camera_node("camera", {0, 2, 5}, {0, 0.5f, 0});
  return builder.build();
}

// Poses of a world: ball, sheet and lamp are elsewhere in each, and move with time. Odd worlds mirror the
// ball.
state::RestPose swinging_pose(const scene::Scene& scene, uint32_t world, uint32_t time) {
  state::RestPose pose = state::rest_pose(scene);
  const float x = 0.35f * static_cast<float>(world) - 0.2f * static_cast<float>(time);
  const auto set = [&](uint32_t node, const glm::mat4& matrix) {
    pose.parent_from_node[node] = pose.world_from_node[node] = matrix;
  };
  set(1, at({x, 0.7f + 0.3f * x, 0.2f}) *
             glm::scale(glm::mat4(1), glm::vec3(world % 2 == 1 ? -1.0f : 1.0f, 1, 1)));
  set(2, at({-1 + x, 1, -1}) * glm::rotate(glm::mat4(1), 1.2f + x, glm::vec3(1, 0, 0.3f)));
  set(3, shining_towards({-1 + x, -2, -0.5f - x}));
  return pose;
}

state::RestPose bar_pose(const scene::Scene& scene, uint32_t world, uint32_t time) {
  BarPose pose;
  pose.root_from_tip = glm::rotate(glm::mat4(1), 0.3f * static_cast<float>(world + time), glm::vec3(0, 0, 1));
  pose.bulge = 0.25f * static_cast<float>(world);
  return moved(scene, pose);
}

// Views of all worlds, not in their order, two of each.
std::vector<passes::View> views_of_worlds() {
  std::vector<passes::View> views;
  for (const uint32_t world : {2u, 0u, 1u, 1u, 0u, 2u}) {
    const float angle = 0.9f * static_cast<float>(views.size());
    passes::Intrinsics k;
    k.fx_px = k.fy_px = 40;
    k.cx_px = 24;
    k.cy_px = 20;
    k.image_px = {kWorldExtent.width, kWorldExtent.height};
    views.push_back(passes::make_view(
        k, passes::look_at_pose({3 * std::sin(angle), 1.5f, 3 * std::cos(angle)}, {0, 0.6f, 0})));
    views.back().world = world;
  }
  return views;
}

template <typename T>
std::vector<T> rows_of_view(const std::vector<T>& all, size_t view, size_t size) {
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(view * size);
  return {begin, begin + static_cast<std::ptrdiff_t>(size)};
}

struct WorldsCase {
  const char* name;
  bool bar;
  uint32_t samples;
  settings::ShadowMethod shadows;
  settings::RayBackEnd back_end = settings::RayBackEnd::query;
};

class Worlds : public ValidationIsSilent, public ::testing::WithParamInterface<WorldsCase> {
 protected:
  Worlds() : scene_(GetParam().bar ? skinned_bar({}) : swinging_scene()) {
    settings_.samples = GetParam().samples;
    settings_.shadows.method = GetParam().shadows;
    settings_.shadows.back_end = GetParam().back_end;
    settings_.post.fxaa = false;  // unavailable for several views
    for (uint32_t world = 0; world < kWorlds; ++world) worlds_.push_back(&poses_.emplace_back(scene_));
    set_time(0);
  }
  void set_time(uint32_t time) {
    for (uint32_t world = 0; world < kWorlds; ++world)
      poses_[world].set_rest(GetParam().bar ? bar_pose(scene_, world, time)
                                            : swinging_pose(scene_, world, time));
  }

  scene::Scene scene_;
  std::deque<state::PoseState> poses_;
  std::vector<const state::PoseState*> worlds_;
  settings::DrawSettings settings_;
};

TEST_P(Worlds, EachViewEqualsItsWorldAlone) {
  const std::vector<passes::View> views = views_of_worlds();
  wire::ImageOutputs outputs = wire::ImageOutputs::all_planes();
  outputs.remove(wire::kColorLinearF16);
  RenderBench together(scene_, kWorldExtent, settings_);
  together.renderer().set_scene(scene_, kWorlds);
  std::vector<std::unique_ptr<RenderBench>> alone;
  for (uint32_t world = 0; world < kWorlds; ++world)
    alone.push_back(std::make_unique<RenderBench>(scene_, kWorldExtent, settings_));
  std::vector<passes::CameraHistory> histories(views.size()), histories_alone(views.size());
  std::vector<std::vector<uint8_t>> first_images;
  for (uint32_t time = 0; time < 2; ++time) {
    set_time(time);
    const Taken all = together.take(worlds_, views, outputs, histories);
    constexpr size_t kPixels = size_t{kWorldExtent.width} * kWorldExtent.height;
    ASSERT_EQ(all.image.rgba8.size(), 4 * kPixels * views.size());
    for (size_t v = 0; v < views.size(); ++v) {
      SCOPED_TRACE("view " + std::to_string(v) + " at " + std::to_string(time));
      passes::View view = views[v];
      view.world = 0;
      const Taken one =
          alone[views[v].world]->take(poses_[views[v].world], view, outputs, &histories_alone[v]);
      EXPECT_EQ(rows_of_view(all.image.rgba8, v, 4 * kPixels), one.image.rgba8);
      ASSERT_EQ(one.places.size(), 10u);
      for (const passes::PlaneRange& place : one.places)
        EXPECT_EQ(rows_of_view(all.plane<uint8_t>(place.output), v, place.size_bytes),
                  one.plane<uint8_t>(place.output))
            << wire::info_of(place.output).api_name;
      first_images.push_back(one.image.rgba8);
    }
  }
  // The worlds and times differ, or the test would prove nothing: from the same camera as well.
  passes::View view = views[0];
  view.world = 0;
  const sinks::FrameImage of_first = alone[0]->draw(poses_[0], view),
                          of_second = alone[1]->draw(poses_[1], view);
  EXPECT_NE(of_first.rgba8, of_second.rgba8);
  EXPECT_NE(first_images[0], first_images[views.size()]);
}

// Frames of single views, which may be drawn forward, one world after the other.
TEST_P(Worlds, AlternatingFramesEqualEachAlone) {
  settings_.raster = settings::RasterPath::forward;
  RenderBench together(scene_, kWorldExtent, settings_);
  together.renderer().set_scene(scene_, kWorlds);
  std::vector<std::unique_ptr<RenderBench>> alone;
  for (uint32_t world = 0; world < kWorlds; ++world)
    alone.push_back(std::make_unique<RenderBench>(scene_, kWorldExtent, settings_));
  for (const passes::View& view : views_of_worlds()) {
    SCOPED_TRACE(view.world);
    const Taken image = together.take(worlds_, std::span(&view, 1), {});
    passes::View same = view;
    same.world = 0;
    EXPECT_EQ(image.image.rgba8, alone[view.world]->draw(poses_[view.world], same).rgba8);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Worlds,
                         ::testing::Values(WorldsCase{"NoShadows", false, 1, settings::ShadowMethod::off},
                                           WorldsCase{"Maps", false, 4, settings::ShadowMethod::map},
                                           WorldsCase{"RayQuery", false, 4, settings::ShadowMethod::ray},
                                           WorldsCase{"RayPipeline", false, 1, settings::ShadowMethod::ray,
                                                      settings::RayBackEnd::pipeline},
                                           WorldsCase{"DeformedMaps", true, 1, settings::ShadowMethod::map},
                                           WorldsCase{"DeformedRays", true, 4, settings::ShadowMethod::ray}),
                         [](const ::testing::TestParamInfo<WorldsCase>& one) {
                           return std::string(one.param.name);
                         });

}  // namespace
}  // namespace fire3dv::test
