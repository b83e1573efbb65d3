// Test of the window's guides: size of grid cells, lines through the origin, frusta against the view that the
// camera has, and markers that follow the nodes of cameras.
#include "renderer/window/guides.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "renderer/passes/view/view.h"
#include "renderer/window/overlay_colors.h"
#include "renderer/window/overlay_markers.h"
#include "tests/unit/renderer/scene/clusters/boxes_scene.h"

namespace fire3dv::app {
namespace {

using wire::Marker;
using wire::MarkerKind;

scene::Scene scene_of(const glm::vec3& low, const glm::vec3& high) {
  scene::Scene scene = boxes_at({{0, 0, 0}});
  scene.bounds_min = low;
  scene.bounds_max = high;
  return scene;
}

glm::vec3 position(const Marker& marker, size_t i) {
  return {marker.positions[i][0], marker.positions[i][1], marker.positions[i][2]};
}

TEST(Guides, CellsAreOneTwoFive) {
  for (float radius = 3e-4f; radius < 3e6f; radius *= 1.37f) {
    const float side = radius / std::sqrt(3.0f);
    const float cell = grid_cell_m(scene_of(glm::vec3(-side), glm::vec3(side)));
    const double log = std::log10(static_cast<double>(cell)),
                 part = std::pow(10, log - std::floor(log + 1e-4));
    EXPECT_TRUE(std::abs(part - 1) < 1e-3 || std::abs(part - 2) < 1e-3 || std::abs(part - 5) < 1e-3) << cell;
    EXPECT_LE(cell, radius / 4 * 1.001f);
    EXPECT_GE(10 * cell, 0.99f * radius) << "ten cells reach from the centre to the end of the scene";
  }
  constexpr float kInfinity = INFINITY;
  EXPECT_EQ(grid_cell_m(scene_of(glm::vec3(0), glm::vec3(0))), 0.2f);
  EXPECT_EQ(grid_cell_m(scene_of(glm::vec3(-kInfinity), glm::vec3(kInfinity))), 0.2f);
}

TEST(Guides, GridLinesMatchCells) {
  const scene::Scene scene = scene_of({27, -1, -1}, {41, 1, 3});  // centre (34, 0, 1)
  const std::vector<Marker> markers = ground_grid(scene, 2);
  ASSERT_EQ(markers.size(), 3u);
  const Marker& lines = markers[0];
  ASSERT_EQ(lines.kind, MarkerKind::lines);
  ASSERT_EQ(lines.positions.size(), 2u * 2 * 21);
  ASSERT_EQ(lines.colors.size(), lines.positions.size());
  const float cell = grid_cell_m(scene);
  EXPECT_EQ(cell, 1);
  float low_x = INFINITY, high_x = -INFINITY;
  for (size_t i = 0; i < lines.positions.size(); i += 2) {
    const glm::vec3 a = position(lines, i), b = position(lines, i + 1);
    EXPECT_EQ(a.y, b.y);
    EXPECT_LT(std::abs(a.y), 0.001f * cell);
    EXPECT_TRUE(a.x == b.x || a.z == b.z);
    EXPECT_EQ(std::round(a.x), a.x);
    EXPECT_EQ(std::round(a.z), a.z);
    const bool is_x_axis = a.z == 0 && b.z == 0, is_z_axis = a.x == 0 && b.x == 0;
    EXPECT_EQ(lines.colors[i] == kAxisColors[0], is_x_axis);
    EXPECT_EQ(lines.colors[i] == kAxisColors[2], is_z_axis);
    low_x = std::min(low_x, a.x);
    high_x = std::max(high_x, b.x);
  }
  EXPECT_EQ(low_x, 24);
  EXPECT_EQ(high_x, 44);
  EXPECT_EQ(markers[1].kind, MarkerKind::axes);
  EXPECT_EQ(markers[2].texts, std::vector<std::string>{"\n1 m"});
  const std::vector<Marker> small = ground_grid(scene, 1);
  for (size_t i = 0; i < 3; ++i) EXPECT_FLOAT_EQ(markers[i].width, 2 * small[i].width);
}

// The far corners of a frustum are those of the camera's image.
TEST(Guides, FrustaEndInCornersOfImage) {
  constexpr float kAspect = 1.5f, kDepth = 4;
  for (const bool orthographic : {false, true}) {
    scene::Camera camera;
    camera.orthographic = orthographic;
    camera.half_extent_m = {3, 2};
    camera.vertical_fov_rad = 0.7f;
    const std::vector<Marker> markers = camera_frustum(camera, "left eye", kDepth, kAspect, false, 1);
    ASSERT_EQ(markers.size(), 2u);
    EXPECT_EQ(markers[1].texts, std::vector<std::string>{"\nleft eye"});
    const glm::mat4 clip_from_camera = passes::clip_from_camera(camera, kAspect);
    std::set<std::pair<int, int>> corners;
    for (size_t i = 0; i < markers[0].positions.size(); ++i) {
      const glm::vec3 at = position(markers[0], i);
      if (std::abs(at.z + kDepth) > 1e-5f) continue;
      const glm::vec4 clip = clip_from_camera * glm::vec4(at, 1);
      const glm::vec2 ndc = glm::vec2(clip) / clip.w;
      if (ndc.y < -1.05f) continue;  // the mark above the image
      EXPECT_NEAR(std::abs(ndc.x), 1, 1e-5f);
      EXPECT_NEAR(std::abs(ndc.y), 1, 1e-5f);
      corners.insert({ndc.x > 0 ? 1 : -1, ndc.y > 0 ? 1 : -1});
    }
    EXPECT_EQ(corners.size(), 4u);
  }
  scene::Camera short_sighted;
  short_sighted.far_m = 1;
  const std::vector<Marker> near = camera_frustum(short_sighted, "", kDepth, kAspect, false, 1);
  for (const auto& at : near.at(0).positions) EXPECT_GE(at[2], -1.00001f) << "beyond the far plane";
}

TEST(Guides, LongNamesEndBetweenTwoCharacters) {
  std::string name;
  for (int i = 0; i < 40; ++i) name += "\u00e9";  // two bytes each
  name.insert(0, "\x01x");
  const std::vector<Marker> markers = camera_frustum({}, name + "\n", 1, 1, false, 1);
  const std::string& text = markers[1].texts[0];
  EXPECT_TRUE(text.starts_with("\n x\u00e9"));
  EXPECT_EQ(text.size(), 1 + 2 + 62u);
}

TEST(Guides, FrustaFollowNodes) {
  scene::Scene scene = boxes_at({{1, 2, 3}});
  scene.nodes[1].camera = 0;  // the box carries a camera, "eye" is the other one
  state::PoseState poses(scene);
  scene::SceneEdits edits;
  OverlayMarkers overlay;
  ViewState view_state;
  view_state.shows_frusta = true;
  const auto shown = [&](uint32_t camera_node) {
    return overlay.update(view_state, {scene, edits, poses, 1, camera_node, 1, 1});
  };
  ASSERT_EQ(shown(scene::kNone).size(), 4u);
  const std::vector<state::ShownMarker> others = shown(2);
  ASSERT_EQ(others.size(), 2u);
  EXPECT_EQ(glm::vec3(others[0].world_from_marker[3]), glm::vec3(1, 2, 3));
  EXPECT_EQ(shown(2)[0].id, others[0].id);
  view_state.selected = 1;
  EXPECT_NE(shown(2)[0].id, others[0].id) << "another colour";
  view_state.shows_frusta = false;
  EXPECT_TRUE(shown(2).empty());
  view_state.shows_grid = true;
  EXPECT_EQ(shown(2).size(), 3u);
}

}  // namespace
}  // namespace fire3dv::app
