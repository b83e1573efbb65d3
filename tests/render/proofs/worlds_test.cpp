// Render test of several worlds of one scene in one submission: each view is bit-identical to one of a scene
// with its world alone.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <memory>
#include <set>
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

// Moves the ball by a stream.
void publish_ball(state::PoseState& poses, const glm::vec3& position) {
  wire::StreamDescription description;
  description.epoch = 1;
  description.node_names = {"ball"};
  wire::Affine3x4 pose;
  for (size_t axis = 0; axis < 3; ++axis) pose.m[4 * axis + 3] = position[static_cast<int>(axis)];
  wire::PoseFrameView frame;
  frame.header.epoch = frame.header.sequence = 1;
  frame.node_count = 1;
  frame.poses = std::span<const wire::Affine3x4>(&pose, 1);
  EXPECT_TRUE(poses.push(poses.add_stream(description), frame));
}

// Batches of many small images: one view of each world, in another order, with small shadow maps at coarse
// levels.
class Streams : public ValidationIsSilent {};
class Batches : public ValidationIsSilent, public ::testing::WithParamInterface<uint32_t> {};

TEST_P(Batches, EachWorldEqualsABatchOfItAlone) {
  constexpr VkExtent2D kSmall{16, 16};
  constexpr size_t kPixels = size_t{kSmall.width} * kSmall.height;
  const scene::Scene scene = swinging_scene();
  settings::DrawSettings settings;
  settings.samples = 1;
  settings.shadows.method = settings::ShadowMethod::map;
  settings.shadows.small_maps = true;
  settings.levels_of_detail = settings::LevelsOfDetail::camera;
  settings.post.fxaa = false;
  const uint32_t count = GetParam();
  std::deque<state::PoseState> poses;
  std::vector<const state::PoseState*> worlds;
  std::vector<passes::View> views;
  for (uint32_t i = 0; i < count; ++i) {
    worlds.push_back(&poses.emplace_back(scene));
    poses[i].set_rest(swinging_pose(scene, i, 0));
    if (i % 3 == 1) publish_ball(poses[i], {0.1f * static_cast<float>(i % 7), 0.8f, 0});
    passes::Intrinsics k;
    k.fx_px = k.fy_px = 14;
    k.cx_px = k.cy_px = 7.5f;
    k.image_px = {kSmall.width, kSmall.height};
    const float angle = 0.7f * static_cast<float>(i);
    views.push_back(passes::make_view(
        k, passes::look_at_pose({3 * std::sin(angle), 1.5f, 3 * std::cos(angle)}, {0, 0.6f, 0})));
    views.back().world = (7 * i + 3) % count;
  }
  wire::ImageOutputs outputs = wire::ImageOutputs::all_planes();
  outputs.remove(wire::kColorLinearF16);
  RenderBench together(scene, kSmall, settings), alone(scene, kSmall, settings);
  together.renderer().set_scene(scene, count);
  const Taken all = together.take(worlds, views, outputs);
  ASSERT_EQ(all.image.rgba8.size(), 4 * kPixels * count);
  std::set<std::vector<uint8_t>> images;
  for (uint32_t v = 0; v < count; ++v) {
    SCOPED_TRACE(v);
    passes::View view = views[v];
    view.world = 0;
    alone.renderer().set_scene(scene);  // other poses with the same revisions
    const Taken one = alone.take(poses[views[v].world], view, outputs);
    EXPECT_EQ(rows_of_view(all.image.rgba8, v, 4 * kPixels), one.image.rgba8);
    for (const passes::PlaneRange& place : one.places) {
      const std::vector<uint8_t> plane = one.plane<uint8_t>(place.output);
      EXPECT_EQ(rows_of_view(all.plane<uint8_t>(place.output), v, plane.size()), plane)
          << wire::info_of(place.output).api_name;
    }
    images.insert(one.image.rgba8);
  }
  EXPECT_EQ(images.size(), count);  // alike worlds would prove nothing
}

INSTANTIATE_TEST_SUITE_P(Worlds, Batches, ::testing::Values(2u, 33u));

// Streams that come later lay out the poses of all worlds again: those of the others stay.
TEST_F(Streams, LaterOnesLeaveThePosesOfOtherWorlds) {
  const scene::Scene scene = swinging_scene();
  settings::DrawSettings settings;
  settings.samples = 1;
  settings.shadows.method = settings::ShadowMethod::off;
  settings.post.fxaa = false;
  std::deque<state::PoseState> poses;
  std::vector<const state::PoseState*> worlds;
  for (uint32_t world = 0; world < kWorlds; ++world) worlds.push_back(&poses.emplace_back(scene));
  const std::vector<passes::View> views = views_of_worlds();
  constexpr size_t kBytes = size_t{4} * kWorldExtent.width * kWorldExtent.height;
  RenderBench together(scene, kWorldExtent, settings), alone(scene, kWorldExtent, settings);
  together.renderer().set_scene(scene, kWorlds);
  Taken before = together.take(worlds, views, {});
  for (uint32_t published = 0; published < kWorlds; ++published) {
    publish_ball(poses[published], {0.4f * static_cast<float>(published) - 0.6f, 0.9f, 0});
    const Taken all = together.take(worlds, views, {});
    for (size_t v = 0; v < views.size(); ++v) {
      SCOPED_TRACE("view " + std::to_string(v) + " after world " + std::to_string(published));
      passes::View view = views[v];
      view.world = 0;
      alone.renderer().set_scene(scene);  // other poses with the same revisions
      EXPECT_EQ(rows_of_view(all.image.rgba8, v, kBytes), alone.draw(poses[views[v].world], view).rgba8);
      EXPECT_EQ(rows_of_view(all.image.rgba8, v, kBytes) != rows_of_view(before.image.rgba8, v, kBytes),
                views[v].world == published);
    }
    before = all;
  }
}

// A robot of five links on a floor, in a random pose.
scene::Scene robot(uint32_t seed) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({0.8f, 0.8f, 0.8f})),
                 dark = builder.material(matte({0.25f, 0.25f, 0.3f}));
  builder.mesh_node("floor", builder.quad(white, 3), glm::mat4(1));
  builder.mesh_node("base",
                    builder.lathe(
                        dark,
                        [](float theta, float phi) {
                          return 0.16f * glm::vec3(std::sin(theta) * std::cos(phi), std::cos(theta),
                                                   std::sin(theta) * std::sin(phi));
                        },
                        48),
                    at({0, 0.1f, 0}));
  const uint32_t joint = builder.sphere(dark, 0.09f, 48), link = builder.box(white, {0.055f, 0.15f, 0.055f});
  glm::mat4 world_from_joint = at({0, 0.2f, 0});
  for (uint32_t i = 0; i < 5; ++i) {
    const auto turn = [&](uint32_t step) {
      return std::sin(12.9898f * static_cast<float>(seed) + 4.1f * static_cast<float>(i + 7 * step));
    };
    world_from_joint = world_from_joint * glm::rotate(glm::mat4(1), 2 * turn(0), glm::vec3(0, 1, 0)) *
                       glm::rotate(glm::mat4(1), 0.8f * turn(1), glm::vec3(0, 0, 1));
    builder.mesh_node("joint " + std::to_string(i), joint, world_from_joint);
    builder.mesh_node("link " + std::to_string(i), link, world_from_joint * at({0, 0.16f, 0}));
    world_from_joint = world_from_joint * at({0, 0.32f, 0});
  }
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-1, -2, -0.5f}));
  builder.camera_node("camera", {1.6f, 1.3f, 2}, {0, 0.6f, 0});
  return builder.build();
}

class SmallMaps : public ValidationIsSilent {};

// Small maps show the shadows of rays, but for the borders of shadows and pixels that light falls on flat.
TEST_F(SmallMaps, DifferFromRaysInFewPixels) {
  settings::DrawSettings settings;
  settings.samples = 1;
  settings.post.fxaa = false;
  settings.levels_of_detail = settings::LevelsOfDetail::camera;
  constexpr settings::ShadowMethod kMethods[] = {settings::ShadowMethod::map, settings::ShadowMethod::ray,
                                                 settings::ShadowMethod::off};
  std::deque<scene::Scene> robots;
  for (uint32_t seed = 0; seed < 4; ++seed) robots.push_back(robot(seed));
  std::deque<RenderBench> benches;
  for (const settings::ShadowMethod method : kMethods) {
    settings.shadows = {.method = method, .hybrid = false, .small_maps = true};
    benches.emplace_back(robots[0], VkExtent2D{64, 64}, settings);
  }
  for (const uint32_t side : {64u, 128u}) {
    uint32_t covered = 0, differing = 0, shadowed = 0;
    for (const scene::Scene& scene : robots) {
      const state::PoseState poses(scene);
      const passes::View view = passes::make_view(scene.cameras[0], scene.nodes.back().world_from_node, 1);
      std::vector<Taken> taken;
      for (RenderBench& bench : benches) {
        bench.renderer().set_scene(scene);
        bench.set_size({side, side});
        taken.push_back(bench.take(poses, view, wire::ImageOutputs(wire::kColorSrgb8 | wire::kInstanceU32)));
      }
      const Taken &by_maps = taken[0], &by_rays = taken[1], &without = taken[2];
      const std::vector<uint32_t> instances = by_rays.plane<uint32_t>(wire::kInstanceU32);
      for (size_t pixel = 0; pixel < instances.size(); ++pixel) {
        if (instances[pixel] == 0) continue;
        ++covered;
        const auto differs = [&](const Taken& image) {
          bool more = false;
          for (size_t c = 4 * pixel; c < 4 * pixel + 3; ++c) {
            const int ray = by_rays.image.rgba8[c];
            more |= 10 * std::abs(image.image.rgba8[c] - ray) > ray;
          }
          return more;
        };
        differing += differs(by_maps) ? 1 : 0;
        shadowed += differs(without) ? 1 : 0;
      }
    }
    EXPECT_GT(33 * shadowed, covered) << "shadows are missing in the reference";
    EXPECT_LE(50 * differing, covered)
        << differing << " of " << covered << ", of " << shadowed << " in shadow, at " << side << " pixels";
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
