// Render test of debug views, picking and outlines against the scene and the output planes of the same image.
// Without an inspection the image stays byte-identical.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>
#include <map>
#include <set>
#include <tuple>

#include "tests/render/support/bent_bar.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

using passes::Inspection;
using settings::DebugView;

constexpr VkExtent2D kExtent{160, 120};
constexpr uint32_t kStacks[] = {1, 2, 4, 16};
const glm::ivec3 kNothing{15, 15, 15};

// Stacks of one, two, four and sixteen plates, a ramp, a wall, and a ball with a hat, before the background.
scene::Scene desk(bool orthographic = false) {
  SceneBuilder builder;
  const uint32_t plate = builder.quad(builder.material(matte({0.7f, 0.6f, 0.5f})), 0.6f);
  const uint32_t ball = builder.sphere(builder.material(matte({0.3f, 0.5f, 0.7f})), 0.8f, 96);
  const uint32_t hat = builder.box(builder.material(matte({0.8f, 0.2f, 0.2f})), {0.4f, 0.2f, 0.4f});
  for (size_t s = 0; s < std::size(kStacks); ++s) {
    for (uint32_t i = 0; i < kStacks[s]; ++i) {
      builder.mesh_node("plate", plate,
                        at({-3 + 2 * static_cast<float>(s), 0.02f * static_cast<float>(i), 2}));
    }
  }
  const float right_angle = 1.57079633f;
  builder.mesh_node("ramp", plate,
                    glm::rotate(at({-2.5f, 0.5f, -0.5f}), -right_angle / 2, glm::vec3(0, 0, 1)));
  builder.mesh_node("wall", plate, glm::rotate(at({-0.5f, 0.6f, -2}), right_angle, glm::vec3(1, 0, 0)));
  const uint32_t round = builder.mesh_node("ball", ball, at({1.8f, 0.8f, -1}));
  builder.mesh_node("hat", hat, at({0, 0.9f, 0}), round);
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.5f, -1, -0.3f}));
  builder.camera_node("camera", {0, 7, 6}, {0, 0, 0}, 0.8f);
  scene::Scene scene = builder.build();
  if (orthographic) {
    scene.cameras[0].orthographic = true;
    scene.cameras[0].half_extent_m = {3.5f * 4 / 3, 3.5f};
    scene.cameras[0].far_m = 40;
  }
  return scene;
}

uint32_t named(const scene::Scene& scene, const std::string& name) {
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].name == name) return n;
  }
  ADD_FAILURE() << "no node " << name;
  return 0;
}

class Inspected {
 public:
  explicit Inspected(scene::Scene scene, uint32_t samples, bool fxaa = true)
      : scene_(std::move(scene)),
        poses_(scene_),
        bench_(scene_, kExtent, settings_of(samples, fxaa)),
        belt_(device()) {}

  sinks::FrameImage draw(const Inspection& inspection) {
    sinks::FrameImage image;
    begin(inspection);
    belt_.drain([&](int, VkExtent2D extent, std::span<const uint8_t> rgba8) {
      image.width = extent.width;
      image.height = extent.height;
      image.rgba8.assign(rgba8.begin(), rgba8.end());
    });
    return image;
  }
  // Submits a frame without waiting for it.
  void begin(const Inspection& inspection) {
    const passes::PreparedFrame prepared = bench_.prepare({.inspection = inspection});
    gpu::Recorder& recorder = bench_.frames().begin();
    renderer().record(prepared, recorder, bench_.frames().staging(), poses_, view());
    belt_.record(recorder, renderer().image(), 0);
    const uint64_t done_at = bench_.frames().submit();
    belt_.submitted(done_at);
    renderer().submitted(done_at);
  }
  void finish() {
    belt_.drain([](int, VkExtent2D, std::span<const uint8_t>) {});
  }
  Taken planes() {
    wire::ImageOutputs outputs;
    outputs.add(wire::kInstanceU32), outputs.add(wire::kDepthF32);
    outputs.add(wire::kNormal);
    return bench_.take(poses_, view(), outputs);
  }
  passes::View view() { return first_camera_view(scene_, poses_, kExtent); }
  glm::vec2 pixel_of(const glm::vec3& world) {
    const glm::vec4 clip = view().clip_from_world * glm::vec4(world, 1);
    return (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * glm::vec2(kExtent.width, kExtent.height);
  }
  passes::SceneRenderer& renderer() { return bench_.renderer(); }
  const scene::Scene& scene() const { return scene_; }
  const state::PoseState& poses() const { return poses_; }

 private:
  static settings::DrawSettings settings_of(uint32_t samples, bool fxaa) {
    settings::DrawSettings settings;
    settings.samples = samples;
    settings.post.fxaa = fxaa;
    return settings;
  }

  scene::Scene scene_;
  state::PoseState poses_;
  RenderBench bench_;
  gpu::ReadbackRing<int> belt_;
};

glm::ivec3 at_index(const sinks::FrameImage& image, size_t i) {
  return pixel(image, static_cast<uint32_t>(i % image.width), static_cast<uint32_t>(i / image.width));
}

// Colour scale of post/debug_view.comp.
glm::ivec3 heat_of(uint32_t count) {
  const float warm = std::min(std::log2(static_cast<float>(count)) / 4, 1.0f);
  const glm::vec3 blue(0, 0, 1), green(0, 1, 0), red(1, 0, 0);
  const glm::vec3 color = warm < 0.5f ? glm::mix(blue, green, warm * 2) : glm::mix(green, red, warm * 2 - 1);
  return {std::lround(color.x * 255), std::lround(color.y * 255), std::lround(color.z * 255)};
}

bool within(const glm::ivec3& a, const glm::ivec3& b, int most) {
  const glm::ivec3 off = glm::abs(a - b);
  return std::max(off.x, std::max(off.y, off.z)) <= most;
}

class Inspect : public ValidationIsSilent, public ::testing::WithParamInterface<uint32_t> {};

TEST_P(Inspect, DebugViewsMatchImage) {
  Inspected inspected(desk(), GetParam());
  const sinks::FrameImage before = inspected.draw({});
  const Taken planes = inspected.planes();
  const auto instance = planes.plane<uint32_t>(wire::kInstanceU32);
  const auto depth = planes.plane<float>(wire::kDepthF32);
  const auto normal = planes.plane<uint64_t>(wire::kNormal);
  ASSERT_EQ(instance.size(), size_t{kExtent.width} * kExtent.height);

  const sinks::FrameImage normals = inspected.draw({DebugView::normals});
  const sinks::FrameImage instances = inspected.draw({DebugView::instances});
  std::map<uint32_t, glm::ivec3> color_of_node;
  for (size_t i = 0; i < instance.size(); ++i) {
    if (instance[i] == 0) {
      ASSERT_EQ(at_index(normals, i), kNothing);
      ASSERT_EQ(at_index(instances, i), kNothing);
      continue;
    }
    const glm::vec3 n(glm::unpackHalf4x16(normal[i]));
    ASSERT_TRUE(within(at_index(normals, i), glm::ivec3(glm::round((n * 0.5f + 0.5f) * 255.0f)), 1)) << i;
    const auto known = color_of_node.try_emplace(instance[i], at_index(instances, i)).first;
    ASSERT_EQ(at_index(instances, i), known->second) << "node " << instance[i] - 1;
  }
  std::set<std::tuple<int, int, int>> colors;
  for (const auto& [node, color] : color_of_node) colors.insert({color.x, color.y, color.z});
  EXPECT_GE(color_of_node.size(), 8u);
  EXPECT_EQ(colors.size(), color_of_node.size());

  // Expectations that need no plane.
  const auto color_at = [&](const sinks::FrameImage& image, const glm::vec3& world) {
    const glm::vec2 place = inspected.pixel_of(world);
    return pixel(image, static_cast<uint32_t>(place.x), static_cast<uint32_t>(place.y));
  };
  EXPECT_TRUE(within(color_at(normals, {-3, 0, 2}), {128, 255, 128}, 1));
  EXPECT_TRUE(within(color_at(normals, {-2.5f, 0.5f, -0.5f}), {218, 218, 128}, 1));
  EXPECT_TRUE(within(color_at(normals, {-0.5f, 0.6f, -2}), {128, 128, 255}, 1));

  // Depth view: the farther, the darker.
  const sinks::FrameImage depths = inspected.draw({DebugView::depth});
  std::vector<size_t> order;
  for (size_t i = 0; i < depth.size(); ++i) {
    if (instance[i] != 0) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return depth[a] < depth[b]; });
  for (size_t i = 1; i < order.size(); ++i)
    ASSERT_LE(at_index(depths, order[i]).x, at_index(depths, order[i - 1]).x);
  EXPECT_EQ(at_index(depths, order.front()), glm::ivec3(255));
  EXPECT_EQ(at_index(depths, order.back()), glm::ivec3(38));

  const sinks::FrameImage overdraw = inspected.draw({DebugView::overdraw});
  for (size_t s = 0; s < std::size(kStacks); ++s) {
    const glm::vec3 middle(-3 + 2 * static_cast<float>(s) + 0.1f, 0.02f * static_cast<float>(kStacks[s]),
                           2.2f);
    EXPECT_TRUE(within(color_at(overdraw, middle), heat_of(kStacks[s]), 1)) << kStacks[s] << " plates";
  }
  for (size_t i = 0; i < instance.size(); ++i) {
    if (GetParam() == 1 && instance[i] == 0) {
      ASSERT_EQ(at_index(overdraw, i), glm::ivec3(0));
    }
  }

  // A plate has one cluster, the ball many.
  const sinks::FrameImage clusters = inspected.draw({DebugView::clusters});
  std::map<uint32_t, std::set<std::tuple<int, int, int>>> clusters_of_node;
  for (size_t i = 0; i < instance.size(); ++i) {
    const glm::ivec3 color = at_index(clusters, i);
    if (instance[i] != 0) clusters_of_node[instance[i] - 1].insert({color.x, color.y, color.z});
  }
  EXPECT_EQ(clusters_of_node[named(inspected.scene(), "wall")].size(), 1u);
  EXPECT_GE(clusters_of_node[named(inspected.scene(), "ball")].size(), 8u);

  EXPECT_EQ(inspected.draw({}).rgba8, before.rgba8);
}

TEST_P(Inspect, UnresolvedShadowsMarkRayPixels) {
  Inspected inspected(desk(), GetParam());
  ASSERT_TRUE(inspected.renderer().can_show(DebugView::unresolved_shadows).ok());
  sinks::FrameImage image;
  for (int i = 0; i < 3; ++i)
    image = inspected.draw({DebugView::unresolved_shadows});  // counters arrive two frames later
  uint64_t marked = 0;
  for (size_t i = 0; i < image.rgba8.size() / 4; ++i) {
    const glm::ivec3 color = at_index(image, i);
    if (color == glm::ivec3(255, 153, 0)) {
      ++marked;
      continue;
    }
    ASSERT_TRUE(color.x == color.y && color.y == color.z && color.x <= 128) << i;
  }
  EXPECT_GT(marked, 0u);
  EXPECT_LE(marked, inspected.renderer().counts().shadow_rays);
  EXPECT_GE(marked * GetParam(), inspected.renderer().counts().shadow_rays);
}

// A bent bar beside the same mesh without a skin.
scene::Scene skinned_group() {
  BarPose pose;
  pose.root_from_tip = glm::rotate(at({0, 1, 0}), 0.6f, glm::vec3(0, 0, 1));
  return skinned_bar(pose);
}

TEST_P(Inspect, PicksAreWhatThePlanesSay) {
  for (scene::Scene scene : {desk(), desk(true), skinned_group(), morphed_bar(0.5f)}) {
    const size_t least_nodes = scene.nodes.size() > 10 ? 5 : 2;
    Inspected inspected(std::move(scene), GetParam());
    const Taken planes = inspected.planes();
    const auto instance = planes.plane<uint32_t>(wire::kInstanceU32);
    const auto depth = planes.plane<float>(wire::kDepthF32);
    std::vector<passes::Picked> picked;
    uint64_t wanted = 0;
    // Frames in flight: no wait between two picks.
    for (uint32_t y = 5; y < kExtent.height; y += 17) {
      for (uint32_t x = 3; x < kExtent.width; x += 23) {
        Inspection inspection;
        inspection.pick = passes::Pick{x, y, y * 1000 + x};
        inspected.begin(inspection);
        ++wanted;
        for (const passes::Picked& one : inspected.renderer().take_picked()) picked.push_back(one);
      }
    }
    inspected.finish();
    for (const passes::Picked& one : inspected.renderer().take_picked()) picked.push_back(one);
    ASSERT_EQ(picked.size(), wanted);
    const passes::View view = inspected.view();
    std::set<uint32_t> nodes;
    uint64_t last_tag = 0;
    for (const passes::Picked& one : picked) {
      EXPECT_GT(one.tag, last_tag);
      last_tag = one.tag;
      const uint64_t x = one.tag % 1000, y = one.tag / 1000, i = y * kExtent.width + x;
      nodes.insert(one.node);
      ASSERT_EQ(one.node, instance[i] - 1) << x << ", " << y;  // 0 - 1: none
      ASSERT_EQ(one.depth_m, depth[i]);
      if (one.node == scene::kNone) continue;
      EXPECT_NEAR(glm::dot(one.position_world - view.eye_world, view.look_world), one.depth_m,
                  (GetParam() == 1 ? 1e-4f : 2e-2f) * one.depth_m);
      const bool is_skinned = inspected.scene().nodes[one.node].skin != scene::kNone;
      ASSERT_EQ(one.world_from_node.has_value(), !is_skinned);
      if (one.world_from_node) {
        ASSERT_EQ(*one.world_from_node, inspected.poses().world_from_node(one.node));
      }
      const glm::vec2 place = inspected.pixel_of(one.position_world);
      EXPECT_NEAR(place.x, static_cast<float>(x) + 0.5f, GetParam() == 1 ? 0.02f : 0.5f);
      EXPECT_NEAR(place.y, static_cast<float>(y) + 0.5f, GetParam() == 1 ? 0.02f : 0.5f);
    }
    EXPECT_GE(nodes.size(), least_nodes);
  }
}

// Skinned nodes share the transform of their parts, but are selected and coloured each by itself.
TEST_P(Inspect, SkinnedNodeIsOutlined) {
  Inspected inspected(skinned_group(), GetParam());
  const uint32_t bar = named(inspected.scene(), "bar");
  const auto instance = inspected.planes().plane<uint32_t>(wire::kInstanceU32);
  const sinks::FrameImage instances = inspected.draw({DebugView::instances});
  const sinks::FrameImage before = inspected.draw({});
  const sinks::FrameImage outlined = inspected.draw({DebugView::none, bar});
  std::map<uint32_t, glm::ivec3> color_of_node;
  uint32_t lines = 0, far_lines = 0;
  for (size_t i = 0; i < instance.size(); ++i) {
    if (instance[i] != 0) color_of_node.try_emplace(instance[i] - 1, at_index(instances, i));
    if (at_index(outlined, i) == at_index(before, i)) continue;
    ++lines;
    bool is_near = false;
    const int x = static_cast<int>(i % kExtent.width), y = static_cast<int>(i / kExtent.width);
    for (int dy = -5; dy <= 5; ++dy) {
      for (int dx = -5; dx <= 5; ++dx) {
        const int px = std::clamp(x + dx, 0, static_cast<int>(kExtent.width) - 1),
                  py = std::clamp(y + dy, 0, static_cast<int>(kExtent.height) - 1);
        is_near |= instance[static_cast<size_t>(py) * kExtent.width + static_cast<size_t>(px)] == bar + 1;
      }
    }
    far_lines += is_near ? 0 : 1;
  }
  EXPECT_GT(lines, 40u);
  EXPECT_EQ(far_lines, 0u);
  ASSERT_TRUE(color_of_node.contains(bar));
  for (const auto& [node, color] : color_of_node) {
    if (node != bar) {
      EXPECT_NE(color, color_of_node[bar]) << node;
    }
  }
}

// The selected node keeps its appearance, the outline lies beside it, and distant pixels stay unchanged.
TEST_P(Inspect, OutlineIsAroundSelectedNodeAlone) {
  Inspected inspected(desk(), GetParam());
  const sinks::FrameImage before = inspected.draw({});
  const auto instance = inspected.planes().plane<uint32_t>(wire::kInstanceU32);
  const uint32_t ball = named(inspected.scene(), "ball"), hat = named(inspected.scene(), "hat");
  const auto check = [&](uint32_t selected, const std::set<uint32_t>& nodes) {
    const sinks::FrameImage outlined = inspected.draw({DebugView::none, selected});
    uint32_t lines = 0;
    for (int i = 0; i < static_cast<int>(instance.size()); ++i) {
      const int x = i % static_cast<int>(kExtent.width), y = i / static_cast<int>(kExtent.width);
      float nearest = 1e9f, nearest_other = 1e9f;
      for (int dy = -6; dy <= 6; ++dy) {
        for (int dx = -6; dx <= 6; ++dx) {
          const int px = x + dx, py = y + dy;
          if (px < 0 || py < 0 || px >= static_cast<int>(kExtent.width) ||
              py >= static_cast<int>(kExtent.height))
            continue;
          const uint32_t shown = instance[static_cast<size_t>(py) * kExtent.width + static_cast<size_t>(px)];
          const float away = std::hypot(static_cast<float>(dx), static_cast<float>(dy));
          float& least = shown != 0 && nodes.contains(shown - 1) ? nearest : nearest_other;
          least = std::min(least, away);
        }
      }
      const bool inside = nearest == 0, changed = at_index(outlined, i) != at_index(before, i);
      // With four samples a pixel at the border may contain a part of the outline.
      const float unsure = GetParam() == 1 ? 0 : 1.5f;
      if (inside && nearest_other > unsure) {
        ASSERT_FALSE(changed) << x << ", " << y;
      }
      if (nearest >= 3.5f + unsure) {
        ASSERT_FALSE(changed) << x << ", " << y;
      }
      if (!inside && nearest <= 1.5f && GetParam() == 1) {
        ASSERT_TRUE(within(at_index(outlined, i), {255, 140, 13}, 1)) << x << ", " << y;
        ++lines;
      }
      lines += at_index(outlined, i) == glm::ivec3(255, 140, 13) ? 1 : 0;
    }
    EXPECT_GT(lines, GetParam() == 1 ? 40u : 15u);
  };
  check(hat, {hat});
  check(ball, {ball, hat});
  EXPECT_EQ(inspected.draw({DebugView::none, static_cast<uint32_t>(inspected.scene().nodes.size())}).rgba8,
            before.rgba8);
  EXPECT_EQ(inspected.draw({}).rgba8, before.rgba8);
}

INSTANTIATE_TEST_SUITE_P(Samples, Inspect, ::testing::Values(1u, 4u));

}  // namespace
}  // namespace fire3dv::test
