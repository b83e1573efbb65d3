// Test of camera placement: all points are inside the margins, and no nearer camera shows them.
#include "renderer/passes/view/framing.h"
#include "renderer/passes/view/facing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "renderer/passes/view/view.h"

namespace fire3dv::test {
namespace {

struct Extent {
  glm::dvec2 low{1e9}, high{-1e9};
  double nearest_m = 1e9;
};

Extent extent_of(const scene::Camera& camera, float aspect, const glm::mat4& pose,
                 const std::vector<glm::vec3>& points) {
  Extent extent;
  const double focal = 1 / std::tan(0.5 * camera.vertical_fov_rad);
  for (const glm::vec3& point : points) {
    const glm::dvec3 p =
        glm::transpose(glm::dmat3(pose)) * (glm::dvec3(point) - glm::dvec3(glm::vec3(pose[3])));
    EXPECT_LT(p.z, 0);
    extent.nearest_m = std::min(extent.nearest_m, -p.z);
    const glm::dvec2 ndc(focal / aspect * p.x / -p.z, focal * p.y / -p.z);
    extent.low = glm::min(extent.low, ndc);
    extent.high = glm::max(extent.high, ndc);
  }
  return extent;
}

TEST(Framing, PointsTouchMarginsOnOppositeSides) {
  constexpr double kEdge = 1 - 2 * static_cast<double>(passes::kFramingMargin);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const glm::vec3 center =
        (i % 3 == 0 ? 1000.0f : 1.0f) * glm::vec3(unit(random), unit(random), unit(random));
    const glm::vec3 size(0.1f + std::abs(unit(random)), 0.1f + std::abs(unit(random)),
                         std::abs(unit(random)));
    std::vector<glm::vec3> points(1 + static_cast<size_t>(i) % 40);
    for (glm::vec3& point : points)
      point = center + size * glm::vec3(unit(random), unit(random), unit(random));
    const glm::vec3 direction = glm::normalize(glm::vec3(unit(random), 0.5f * unit(random), 1.1f));
    scene::Camera camera;
    camera.vertical_fov_rad = 0.3f + std::abs(unit(random));
    const float aspect = 0.4f + 2 * std::abs(unit(random));
    const glm::mat4 pose =
        passes::fit_into_view(camera, aspect, passes::look_at_pose(direction, glm::vec3(0)), points);
    const Extent extent = extent_of(camera, aspect, pose, points);
    const double rounding = i % 3 == 0 ? 1e-2 : 1e-4;
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_LE(extent.high[axis], kEdge + rounding) << i;
      EXPECT_GE(extent.low[axis], -kEdge - rounding) << i;
    }
    if (extent.nearest_m < 1.1 * static_cast<double>(camera.near_m)) continue;  // the near plane decides
    const bool touches_x = extent.high.x > kEdge - rounding && extent.low.x < -kEdge + rounding;
    const bool touches_y = extent.high.y > kEdge - rounding && extent.low.y < -kEdge + rounding;
    EXPECT_TRUE(touches_x || touches_y)
        << i << ": " << extent.low.x << " " << extent.high.x << " " << extent.low.y << " " << extent.high.y;
  }
}

TEST(Framing, WithoutPointsCameraStaysAtOrigin) {
  const glm::mat4 pose = passes::fit_into_view(scene::Camera(), 1, passes::default_orientation(), {});
  EXPECT_EQ(glm::vec3(pose[3]), glm::vec3(0));
}

TEST(Framing, ScaleAndPositionAreIgnored) {
  const std::vector<glm::vec3> points{{-1, 0, 0}, {1, 0.5f, 0}, {0, 0, 1}};
  glm::mat4 scaled = passes::default_orientation() * 3.0f;
  scaled[3] = glm::vec4(5, 6, 7, 1);
  const glm::mat4 a = passes::fit_into_view(scene::Camera(), 1.5f, passes::default_orientation(), points);
  const glm::mat4 b = passes::fit_into_view(scene::Camera(), 1.5f, scaled, points);
  for (int column = 0; column < 4; ++column) EXPECT_LT(glm::length(a[column] - b[column]), 1e-5f);
}

// A triangle mesh on a moved node, a skinned mesh with one joint, and one with a NaN.
TEST(Framing, PointsOfAScene) {
  scene::Scene scene;
  scene.positions = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {1, 1, 1}, {std::nanf(""), 0, 0}};
  scene.primitives.resize(1);
  scene.primitives[0].vertex_count = 5;
  scene.primitives[0].bounds_max = {2, 3, 1};
  scene.meshes.resize(1);
  scene.meshes[0].primitive_count = 1;
  scene.nodes.resize(2);
  scene.nodes[1].mesh = 0;
  const std::vector<glm::mat4> world{glm::mat4(1), glm::translate(glm::mat4(1), {10, 0, 0})};
  std::vector<glm::vec3> points = passes::framing_points(scene, world);
  ASSERT_EQ(points.size(), 4u);
  EXPECT_EQ(points[2], glm::vec3(10, 3, 0));

  scene.joints.push_back({0, glm::translate(glm::mat4(1), {0, 0, -5})});
  scene.skins.resize(1);
  scene.skins[0].joint_count = 1;
  scene.joint_bounds.push_back({0, {0, 0, 0}, {2, 3, 1}});
  scene.primitives[0].joint_bounds_count = 1;
  scene.nodes[1].skin = 0;
  points = passes::framing_points(scene, world);
  ASSERT_EQ(points.size(), 8u);
  EXPECT_EQ(points.back(), glm::vec3(2, 3, -4)) << "the joint's node and bind matrix, not the mesh's node";
}

// A triangle in the plane z = 0 whose front is towards +z, at several transforms of its node.
TEST(Facing, DefaultViewIsFromFront) {
  scene::Scene scene;
  scene.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  scene.indices = {0, 1, 2};
  scene.materials.resize(1);
  scene.primitives.resize(1);
  scene.primitives[0].index_count = 3;
  scene.primitives[0].vertex_count = 3;
  scene.meshes.resize(1);
  scene.meshes[0].primitive_count = 1;
  scene.nodes.resize(1);
  scene.nodes[0].mesh = 0;
  const auto view_of = [&](const glm::mat4& world_from_node) {
    const std::vector<glm::mat4> world{world_from_node};
    const glm::vec3 to_eye(passes::default_orientation(scene, world)[2]);
    EXPECT_EQ(passes::front_facing_share(scene, nullptr, world, glm::vec4(to_eye, 0)), 1);
    return to_eye;
  };
  const glm::vec3 usual(passes::default_orientation()[2]);
  const auto turned = [](float degrees, const glm::vec3& axis) {
    return glm::rotate(glm::mat4(1), glm::radians(degrees), axis);
  };
  EXPECT_EQ(view_of(glm::mat4(1)), usual);
  EXPECT_LT(glm::length(view_of(turned(180, {0, 1, 0})) - glm::vec3(-usual.x, usual.y, -usual.z)), 1e-6f);
  EXPECT_LT(view_of(glm::scale(glm::mat4(1), glm::vec3(1, 1, -1))).z, -0.1f) << "its front is mirrored, too";
  EXPECT_LT(view_of(turned(90, {1, 0, 0})).y, -0.1f) << "a ceiling is seen from below";

  const std::vector<glm::mat4> away{turned(180, {0, 1, 0})};
  EXPECT_EQ(passes::front_facing_share(scene, nullptr, away, {0, 0, 5, 1}), 0);
  EXPECT_EQ(passes::front_facing_share(scene, nullptr, away, {0, 0, -5, 1}), 1);
  scene.materials[0].double_sided = true;
  EXPECT_EQ(passes::front_facing_share(scene, nullptr, away, {0, 0, 5, 1}), 1);
  EXPECT_EQ(glm::vec3(passes::default_orientation(scene, away)[2]), usual);
}

// A floor 40 m wide below a box of 1 m is left out; one of 2 m belongs to the scene, as a floor alone does.
TEST(Framing, WideFloorsDoNotCount) {
  scene::Scene scene;
  scene.primitives.resize(2);
  scene.primitives[0].bounds_min = glm::vec3(-0.5f);
  scene.primitives[0].bounds_max = glm::vec3(0.5f);
  scene.primitives[1].bounds_min = {-1, 0, -1};
  scene.primitives[1].bounds_max = {1, 0, 1};
  scene.meshes.resize(2);
  scene.meshes[0] = {"box", 0, 1, 0};
  scene.meshes[1] = {"floor", 1, 1, 0};
  scene.nodes.resize(2);
  scene.nodes[0].mesh = 0;
  scene.nodes[1].mesh = 1;
  const auto points = [&](float floor_scale) {
    return passes::framing_points(
        scene, std::vector<glm::mat4>{glm::mat4(1), glm::scale(glm::mat4(1), glm::vec3(floor_scale))});
  };
  EXPECT_EQ(points(20).size(), 8u);
  EXPECT_EQ(points(1).size(), 16u);
  scene.nodes[0].mesh = scene::kNone;
  EXPECT_EQ(points(20).size(), 8u);
}

// Equal borders above and below points of different depths, where the width decides the distance.
TEST(Framing, PointsAreCentred) {
  const std::vector<glm::vec3> floor{{-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {1, 0, 1}};
  scene::Camera camera;
  const glm::mat4 pose = passes::fit_into_view(camera, 1.5f, passes::default_orientation(), floor);
  const Extent extent = extent_of(camera, 1.5f, pose, floor);
  for (int axis = 0; axis < 2; ++axis) EXPECT_NEAR(extent.low[axis], -extent.high[axis], 1e-3) << axis;
  EXPECT_LT(extent.high.y, 0.8);
}

// A robot of ten boxes; a tool far away and a thin axis are left out, a second robot is not.
TEST(Framing, OutliersDoNotCount) {
  scene::Scene scene;
  scene.primitives.resize(1);
  scene.primitives[0].bounds_min = glm::vec3(-0.5f);
  scene.primitives[0].bounds_max = glm::vec3(0.5f);
  scene.primitives[0].vertex_count = 8;
  for (int i = 0; i < 8; ++i)
    scene.positions.emplace_back((i & 1) - 0.5f, (i >> 1 & 1) - 0.5f, (i >> 2 & 1) - 0.5f);
  scene.indices = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                   2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5};
  scene.primitives[0].index_count = static_cast<uint32_t>(scene.indices.size());
  scene.meshes.resize(1);
  scene.meshes[0] = {"box", 0, 1, 0};
  const auto points = [&](const std::vector<std::pair<glm::vec3, glm::vec3>>& others) {
    std::vector<glm::mat4> world;
    for (int i = 0; i < 10; ++i)
      world.push_back(glm::translate(glm::mat4(1), {i % 2, 0.5f * static_cast<float>(i), 0}));
    for (const auto& [at, size] : others) world.push_back(glm::scale(glm::translate(glm::mat4(1), at), size));
    scene.nodes.assign(world.size(), {});
    for (scene::Node& node : scene.nodes) node.mesh = 0;
    const scene::Box bounds = passes::bounds_without_outliers(scene, world);
    EXPECT_EQ(bounds.low.y, others.size() == 1 && others[0].second.y > 1 ? -1.5f : -0.5f);
    return passes::framing_points(scene, world).size() / 8;
  };
  EXPECT_EQ(points({}), 10u);
  EXPECT_EQ(points({{{30, 0, 0}, glm::vec3(0.2f)}, {{31, 0, 0}, glm::vec3(0.3f)}}), 10u) << "a tool far away";
  EXPECT_EQ(points({{{0, 0, 0}, {12, 0.01f, 0.01f}}, {{0, 0, 0}, {0.01f, 0.01f, 12}}}), 10u) << "thin axes";
  EXPECT_EQ(points({{{4, 0, 0}, glm::vec3(0.2f)}}), 11u) << "a tool beside the robot";
  EXPECT_EQ(points({{{30, 0, 0}, glm::vec3(3)}}), 11u) << "as large as the rest";
  EXPECT_EQ(points({{{8e17f, 0, 0}, {12, 0.9f, 12}}}), 10u) << "so far that its vertices fall together";
}

// The default view looks from where the scene says, if its file does.
TEST(Framing, ScenesMayNameTheirDefaultView) {
  scene::Scene scene;
  EXPECT_EQ(passes::default_orientation(scene, {}), passes::default_orientation());
  scene.view_from = glm::normalize(glm::vec3(1, 0.45f, 0.75f));
  const glm::mat4 pose = passes::default_orientation(scene, {});
  EXPECT_LT(glm::distance(glm::vec3(pose[2]), scene.view_from), 1e-6f);
  EXPECT_EQ(pose[3], glm::vec4(0, 0, 0, 1));
}

}  // namespace
}  // namespace fire3dv::test
