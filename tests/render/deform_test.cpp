// Render test of skins and morph targets on the GPU: images equal those of meshes deformed on the CPU, on
// both raster paths, with every shadow technique, and from frame to frame.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/bounds.h"
#include "tests/render/support/bent_bar.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kExtent{160, 120};

struct Way {
  const char* name;
  settings::RasterPath raster;
  settings::ShadowSettings shadows;
};
const Way kConfigurations[] = {
    {"forward", settings::RasterPath::forward, {settings::ShadowMethod::ray}},
    {"hybrid",
     settings::RasterPath::visibility,
     {settings::ShadowMethod::ray, true, settings::RayBackEnd::query}},
    {"rays",
     settings::RasterPath::visibility,
     {settings::ShadowMethod::ray, false, settings::RayBackEnd::query}},
    {"pipeline",
     settings::RasterPath::visibility,
     {settings::ShadowMethod::ray, true, settings::RayBackEnd::pipeline}},
    {"maps", settings::RasterPath::visibility, {settings::ShadowMethod::map}},
    {"forward_maps", settings::RasterPath::forward, {settings::ShadowMethod::map}},
    {"forward_pipeline",
     settings::RasterPath::forward,
     {settings::ShadowMethod::ray, true, settings::RayBackEnd::pipeline}},
};

settings::DrawSettings settings_of(const Way& way) {
  settings::DrawSettings settings;
  settings.raster = way.raster;
  settings.shadows = way.shadows;
  settings.post.fxaa = false;
  return settings;
}

sinks::FrameImage draw(RenderBench& bench, const scene::Scene& scene, const state::PoseState& poses) {
  return bench.draw(poses, first_camera_view(scene, poses, kExtent));
}

sinks::FrameImage draw_static(RenderBench& bench, const scene::Scene& scene) {
  bench.renderer().set_scene(scene);
  return draw(bench, scene, state::PoseState(scene));
}

glm::mat4 turned(float angle, const glm::vec3& axis) {
  return glm::rotate(glm::mat4(1), angle, axis);
}

// The second pose lies elsewhere: stale bounds would lose its shadow.
BarPose one_pose() {
  return {at({-0.6f, 0, 0}), at({0, 1, 0}) * turned(0.9f, {0, 0, 1}), 1};
}
BarPose other_pose() {
  return {at({-2, 0.1f, -1}) * turned(0.7f, {0, 1, 0}),
          at({0.1f, 1.1f, 0}) * turned(-1.1f, {1, 0, 0}) * glm::scale(glm::mat4(1), {1.3f, 1, 0.8f}), 0.4f};
}

class Deform : public ValidationIsSilent {};

TEST_F(Deform, SkinnedBarMatchesComputedBend) {
  const scene::Scene skinned = skinned_bar(one_pose());
  const scene::Scene computed = computed_bar(one_pose()), computed_later = computed_bar(other_pose());
  for (const Way& way : kConfigurations) {
    SCOPED_TRACE(way.name);
    RenderBench bench(skinned, kExtent, settings_of(way));
    state::PoseState poses(skinned);
    const sinks::FrameImage first = draw(bench, skinned, poses);
    poses.set_rest(moved(skinned, other_pose()));
    const sinks::FrameImage later = draw(bench, skinned, poses);
    const sinks::FrameImage still = draw(bench, skinned, poses);
    const std::string name = std::string("deform_bar_") + way.name;
    EXPECT_TRUE(matches_image(first, draw_static(bench, computed), name, Tolerance::colour()));
    EXPECT_TRUE(
        matches_image(later, draw_static(bench, computed_later), name + "_later", Tolerance::colour()));
    EXPECT_TRUE(matches_image(still, later, name + "_still", Tolerance::exact()));
    EXPECT_FALSE(difference_of(first, later, Tolerance::colour()).within(Tolerance::colour()));
  }
}

// A mirroring transform flips the winding, and front faces stay front faces.
TEST_F(Deform, MirroredJointsMatchComputedShape) {
  BarPose pose = one_pose();
  pose.world_from_root = pose.world_from_root * glm::scale(glm::mat4(1), {-1, 1, 1});
  const scene::Scene skinned = skinned_bar(pose), computed = computed_bar(pose);
  for (const Way& way : {kConfigurations[0], kConfigurations[1]}) {
    SCOPED_TRACE(way.name);
    RenderBench bench(skinned, kExtent, settings_of(way));
    const sinks::FrameImage image = draw(bench, skinned, state::PoseState(skinned));
    EXPECT_TRUE(matches_image(image, draw_static(bench, computed), std::string("deform_mirrored_") + way.name,
                              Tolerance::colour()));
  }
}

TEST_F(Deform, MorphWeightsMatchComputedShape) {
  const scene::Scene morphed = morphed_bar(1);
  for (const Way& way : {kConfigurations[0], kConfigurations[1]}) {
    SCOPED_TRACE(way.name);
    RenderBench bench(morphed, kExtent, settings_of(way));
    state::PoseState poses(morphed);
    std::vector<sinks::FrameImage> images;
    const std::vector<float> weights{1, 0, 0.35f};
    for (const float weight : weights) {
      state::RestPose rest = state::rest_pose(morphed);
      rest.morph_weights = {weight};
      poses.set_rest(rest);
      images.push_back(draw(bench, morphed, poses));
    }
    for (size_t i = 0; i < weights.size(); ++i) {
      const std::string name = std::string("deform_morph_") + way.name + "_" + std::to_string(i);
      EXPECT_TRUE(matches_image(images[i], draw_static(bench, computed_morphed_bar(weights[i])), name,
                                Tolerance::colour()));
    }
    EXPECT_FALSE(difference_of(images[0], images[1], Tolerance::colour()).within(Tolerance::colour()));
  }
}

// Screen-space bounds of a node's box: low x, low y, high x, high y.
glm::vec4 box_in_image(const scene::Box& box, const passes::View& view) {
  glm::vec2 low(1e9f), high(-1e9f);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec4 clip = view.clip_from_world * glm::vec4((corner & 1) ? box.high.x : box.low.x,
                                                            (corner & 2) ? box.high.y : box.low.y,
                                                            (corner & 4) ? box.high.z : box.low.z, 1);
    EXPECT_GT(clip.w, 0) << "the box passes the eye: the test means nothing";
    const glm::vec2 place =
        (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * glm::vec2(kExtent.width, kExtent.height);
    low = glm::min(low, place);
    high = glm::max(high, place);
  }
  return {low, high};
}

// Counts the pixels that differ from the background, and those of them outside a rectangle.
std::pair<int, int> covered_and_outside(const sinks::FrameImage& image, const glm::vec4& rectangle) {
  const glm::ivec3 background = pixel(image, 0, 0);
  int covered = 0, outside = 0;
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      if (pixel(image, x, y) == background) continue;
      ++covered;
      const auto px = static_cast<float>(x), py = static_cast<float>(y);
      outside += px + 1 < rectangle.x || py + 1 < rectangle.y || px > rectangle.z || py > rectangle.w;
    }
  }
  return {covered, outside};
}

// Draws the skinned mesh in each pose: it is seen, it moves, and it stays within its bounds.
void expect_to_move_inside_bounds(const scene::Scene& scene,
                                  const std::vector<state::RestPose>& poses_shown) {
  uint32_t figure = scene::kNone;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].skin != scene::kNone) figure = n;
  }
  ASSERT_NE(figure, scene::kNone);
  scene::Box around = scene::bounds_in_world(scene, figure, poses_shown[0].world_from_node);
  for (const state::RestPose& pose : poses_shown) {
    const scene::Box box = scene::bounds_in_world(scene, figure, pose.world_from_node);
    around.add(box.low);
    around.add(box.high);
  }
  scene::Camera camera;
  const float aspect = static_cast<float>(kExtent.width) / static_cast<float>(kExtent.height);
  const passes::View view =
      passes::make_view(camera, passes::framing_camera_pose(camera, aspect, around.low, around.high), aspect);
  for (const Way& way : {kConfigurations[0], kConfigurations[1]}) {
    SCOPED_TRACE(way.name);
    RenderBench bench(scene, kExtent, settings_of(way));
    state::PoseState poses(scene);
    std::vector<sinks::FrameImage> images;
    for (const state::RestPose& pose : poses_shown) {
      poses.set_rest(pose);
      images.push_back(bench.draw(poses, view));
      const scene::Box box = scene::bounds_in_world(scene, figure, pose.world_from_node);
      const auto [covered, outside] = covered_and_outside(images.back(), box_in_image(box, view));
      EXPECT_GT(covered, 300);
      EXPECT_EQ(outside, 0);
    }
    EXPECT_FALSE(difference_of(images[0], images[1], Tolerance::colour()).within(Tolerance::colour()));
  }
}

TEST_F(Deform, SkinnedBarMovesInsideItsBounds) {
  scene::Scene scene = skinned_bar(one_pose());
  scene.nodes[0].mesh = scene.nodes[4].mesh = scene::kNone;  // the ground, and the bar without a skin
  std::vector<state::RestPose> poses_shown;
  for (const BarPose& pose : {one_pose(), other_pose()}) poses_shown.push_back(moved(scene, pose));
  expect_to_move_inside_bounds(scene, poses_shown);
}

TEST_F(Deform, CollectionsFoxMovesInsideItsBounds) {
  FIRE3DV_NEEDS_ASSETS();
  const auto scene = scene::load_gltf(asset_collection_folder() / "bevy/Fox.glb");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  state::AnimationPlayer player(*scene, {0});
  std::vector<state::RestPose> poses_shown;
  for (const double time_s : {0.0, 0.4, 0.9}) poses_shown.push_back(player.at(time_s));
  expect_to_move_inside_bounds(*scene, poses_shown);
}

// All meshes are opaque: rays need triangles only for meshes with per-instance vertices.
TEST_F(Deform, ChangingMeshCastsShadow) {
  const auto scene_with = [](bool box, bool has_instance_vertices) {
    SceneBuilder builder;
    const uint32_t material = builder.material(matte(glm::vec3(0.6f)));
    builder.mesh_node("ground", builder.quad(material, 4), glm::mat4(1));
    const uint32_t mesh = builder.box(material, glm::vec3(0.5f));
    const uint32_t node = builder.mesh_node("box", box ? mesh : scene::kNone, at({0.3f, 1.2f, 0.2f}));
    builder.light_node(sun({1, 1, 1}, 3), shining_towards({0.2f, -1, 0.1f}));
    builder.camera_node("camera", {0, 5, 4}, {0, 0.3f, 0});
    scene::Scene scene = builder.build();
    scene.nodes[node].has_instance_vertices = has_instance_vertices;
    return scene;
  };
  for (const Way& way : kConfigurations) {
    SCOPED_TRACE(way.name);
    const scene::Scene none = scene_with(false, false), still = scene_with(true, false),
                       changing = scene_with(true, true);
    RenderBench bench(changing, kExtent, settings_of(way));
    const sinks::FrameImage image = draw(bench, changing, state::PoseState(changing));
    const sinks::FrameImage expected = draw_static(bench, still);
    EXPECT_TRUE(matches_image(image, expected, std::string("deform_own_") + way.name, Tolerance::colour()));
    EXPECT_FALSE(
        difference_of(draw_static(bench, none), expected, Tolerance::colour()).within(Tolerance::colour()));
  }
}

TEST_F(Deform, ReloadingLeavesNothingBehind) {
  const scene::Scene first = skinned_bar(one_pose()), second = morphed_bar(0.5f);
  RenderBench bench(first, kExtent);
  const auto draw_both = [&] {
    bench.renderer().set_scene(second);
    draw(bench, second, state::PoseState(second));
    bench.renderer().set_scene(first);
    draw(bench, first, state::PoseState(first));
  };
  for (uint32_t frame = 0; frame < gpu::kFramesInFlight; ++frame) draw_both();  // once per frame in flight
  device().retire_all_now();
  const gpu::LiveObjects before = device().live_objects();
  const uint64_t bytes_before = device().allocated_bytes();
  for (int i = 0; i < 4; ++i) draw_both();
  device().retire_all_now();
  EXPECT_EQ(device().live_objects(), before);
  EXPECT_EQ(device().allocated_bytes(), bytes_before);
}

}  // namespace
}  // namespace fire3dv::test
