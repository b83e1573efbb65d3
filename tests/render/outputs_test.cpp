// Render test of output planes against the CPU ray caster: instance, depth, normal and motion of each pixel.
// Planes agree with each other and with the colours, and leave the colours unchanged.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "renderer/passes/outputs/planes_and_boxes.h"
#include "tests/render/proofs/cast_rays.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

scene::Material glowing(glm::vec3 color) {
  scene::Material material = matte(color);
  material.unlit = true;
  return material;
}

// A floor, a tilted rectangle, and boxes that occlude each other.
struct Stage {
  scene::Scene scene;
  std::vector<Face> faces;
};

constexpr uint32_t kBox = 2;  // node
const glm::vec3 kBoxHalf_m{0.5f, 0.7f, 0.3f};

std::vector<glm::mat4> poses_of(const scene::Scene& scene) {
  std::vector<glm::mat4> world_from_node;
  for (const scene::Node& node : scene.nodes) world_from_node.push_back(node.world_from_node);
  return world_from_node;
}

Stage stage() {
  SceneBuilder builder;
  const glm::mat4 turned = glm::rotate(glm::mat4(1), 0.7f, glm::normalize(glm::vec3(1, 2, 3)));
  const glm::mat4 tilted = glm::rotate(glm::mat4(1), 0.9f, glm::vec3(1, 0, 0.2f));
  const uint32_t red = builder.material(glowing({0.9f, 0.1f, 0.1f}));
  const uint32_t green = builder.material(glowing({0.1f, 0.8f, 0.2f}));
  builder.mesh_node("floor", builder.quad(red, 6), glm::mat4(1));
  builder.mesh_node("board", builder.quad(green, 1.5f), at({-1.5f, 1.2f, -2}) * tilted);
  builder.mesh_node("box", builder.box(green, kBoxHalf_m), at({0.4f, 1, 0.2f}) * turned);
  builder.mesh_node("post", builder.box(red, {0.04f, 1.5f, 0.04f}), at({1.2f, 1.5f, 1}));
  builder.camera_node("camera", {0, 3, 6}, {0, 0.8f, 0});
  Stage stage{builder.build(), {}};
  for (uint32_t n = 0; n < stage.scene.nodes.size(); ++n) stage.scene.nodes[n].semantic = 100 + n % 2;
  stage.faces = faces_of(stage.scene, poses_of(stage.scene));
  return stage;
}

constexpr VkExtent2D kExtent{160, 120};

// The principal point is off centre, and pixels are not square.
Eye eye_of(const scene::Scene& scene) {
  passes::Intrinsics k;
  k.fx_px = 150;
  k.fy_px = 140;
  k.cx_px = 70.25f;
  k.cy_px = 64.5f;
  k.image_px = {kExtent.width, kExtent.height};
  return {k, glm::dmat4(scene.nodes.back().world_from_node)};
}

passes::View view_of(const Eye& eye) {
  return passes::make_view(eye.intrinsics, glm::mat4(eye.world_from_camera));
}

wire::ImageOutputs everything() {
  wire::ImageOutputs outputs = wire::ImageOutputs::all_planes();
  return outputs;
}

// Returns the expected content of a pixel (outputs_pass.h); nothing near the edge of another face.
std::optional<Hit> expected(const Eye& eye, const std::vector<Face>& faces, glm::dvec2 pixel,
                            uint32_t samples) {
  if (samples == 1) return eye.cast_surely(faces, pixel);
  constexpr double kPlaces[4][2] = {{-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}};
  std::vector<Hit> hits;
  for (const auto& place : kPlaces) {
    const auto hit = eye.cast_surely(faces, pixel + glm::dvec2(place[0], place[1]));
    if (!hit) return std::nullopt;
    hits.push_back(*hit);
  }
  const auto count = [&](const Hit& of) {
    return std::count_if(hits.begin(), hits.end(), [&](const Hit& h) { return h.instance == of.instance; });
  };
  std::vector<Hit> most;
  for (const Hit& hit : hits) {
    if (!most.empty() && count(hit) > count(most[0])) most.clear();
    if (most.empty() || count(hit) == count(most[0])) most.push_back(hit);
  }
  Hit nearest;
  for (const Hit& hit : most) {
    if (hit.instance == 0) continue;
    const Face& face = faces[hit.face];
    const auto depth = eye.depth_of(face, pixel);
    for (const double by : {-0.01, 0.01}) {  // too near to the edge to decide the coverage of the centre
      for (const glm::dvec2 aside : {glm::dvec2(by, by), glm::dvec2(by, -by)})
        if (eye.depth_of(face, pixel + aside).has_value() != depth.has_value()) return std::nullopt;
    }
    if (!depth || (nearest.instance && nearest.depth_m <= *depth)) continue;
    nearest = hit;
    nearest.depth_m = *depth;
  }
  if (nearest.instance) return nearest;
  for (const Hit& hit : most) {
    if (hit.instance == 0) return hit;
  }
  double inverses = 0;
  for (const Hit& hit : hits) inverses += hit.instance == most[0].instance ? 1 / hit.depth_m : 0;
  most[0].depth_m = static_cast<double>(count(most[0])) / inverses;
  return most[0];
}

settings::DrawSettings with_samples(uint32_t samples) {
  settings::DrawSettings settings;
  settings.samples = samples;
  settings.environment_intensity = 0;
  return settings;
}

class Outputs : public ValidationIsSilent, public ::testing::WithParamInterface<uint32_t> {};
class MoreOutputs : public ValidationIsSilent {};

TEST_P(Outputs, PixelsMatchRayHits) {
  const Stage stage = test::stage();
  const Eye eye = eye_of(stage.scene);
  RenderBench bench(stage.scene, kExtent, with_samples(GetParam()));
  const Taken taken = bench.take(state::PoseState(stage.scene), view_of(eye), everything());
  const auto depth = taken.plane<float>(wire::kDepthF32);
  const auto instance = taken.plane<uint32_t>(wire::kInstanceU32);
  const auto semantic = taken.plane<uint32_t>(wire::kSemanticU32);
  const auto normal = taken.plane<uint64_t>(wire::kNormal);

  size_t compared = 0, edges = 0;
  double worst = 0;
  for (uint32_t y = 0; y < kExtent.height; ++y) {
    for (uint32_t x = 0; x < kExtent.width; ++x) {
      const size_t i = size_t{y} * kExtent.width + x;
      const auto hit = expected(eye, stage.faces, {x, y}, GetParam());
      if (!hit) continue;
      ++compared;
      ASSERT_EQ(instance[i], hit->instance) << "at " << x << ", " << y;
      ASSERT_EQ(semantic[i], hit->instance ? stage.scene.nodes[hit->instance - 1].semantic : 0);
      const glm::vec4 seen_normal = glm::unpackHalf4x16(normal[i]);
      if (hit->instance == 0) {
        ASSERT_TRUE(std::isinf(depth[i]) && depth[i] > 0) << "at " << x << ", " << y;
        ASSERT_EQ(seen_normal, glm::vec4(0));
        continue;
      }
      worst = std::max(worst, std::abs(static_cast<double>(depth[i]) / hit->depth_m - 1));
      ASSERT_LT(worst, 1e-5) << "at " << x << ", " << y << ": " << depth[i] << " m, not " << hit->depth_m;
      ASSERT_LT(glm::distance(glm::dvec3(seen_normal), hit->normal_world), 1.5e-3) << "at " << x << ", " << y;
      edges += hit->instance != eye.cast(stage.faces, {x, y}).instance ? 1 : 0;
    }
  }
  EXPECT_GT(compared, size_t{kExtent.width} * kExtent.height * 95 / 100) << "too much is left out";
  RecordProperty("worst_relative_depth_error", std::to_string(worst));
  EXPECT_EQ(edges > 0, GetParam() == 4) << "of one sample every pixel shows its middle";
}
INSTANTIATE_TEST_SUITE_P(Samples, Outputs, ::testing::Values(1u, 4u));

// Depth and normals of a ball within its tessellation error. Triangles lie inside of the ball by at most R (1
// - cos(a / 2)) for each of two directions, and along a slanted ray by correspondingly more.
TEST_P(Outputs, ABallIsRound) {
  SceneBuilder builder;
  constexpr uint32_t kSegments = 256;
  builder.mesh_node("ball", builder.sphere(builder.material(glowing({1, 1, 1})), 1, kSegments), glm::mat4(1));
  builder.camera_node("camera", {0, 0, 5}, {0, 0, 0}, 2 * std::atan(0.3f));
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, {100, 100}, with_samples(GetParam()));
  const state::PoseState poses(scene);
  const Taken taken = bench.take(poses, first_camera_view(scene, poses, {100, 100}), everything());
  const auto depth = taken.plane<float>(wire::kDepthF32);
  const auto normal = taken.plane<uint64_t>(wire::kNormal);
  // With four samples small triangles may miss the centre: the value is a mean, which is exact for flat
  // surfaces.
  const double slack_m = GetParam() == 1 ? 1e-5 : 5e-4;
  const double inside_m = 2 * (1 - std::cos(glm::radians(180.0) / kSegments));
  size_t compared = 0;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      const glm::dvec3 ray((x - 49.5) / 50 * 0.3, -(y - 49.5) / 50 * 0.3, -1);
      const glm::dvec3 from(0, 0, 5);
      const double a = glm::dot(ray, ray), b = glm::dot(from, ray), c = glm::dot(from, from) - 1;
      if (b * b - a * c < 0.2) continue;
      const double length = (-b - std::sqrt(b * b - a * c)) / a;
      const glm::dvec3 n = from + length * ray;
      const double slant = -glm::dot(n, glm::normalize(ray));
      ++compared;
      const size_t i = static_cast<size_t>(100 * y + x);
      ASSERT_GE(depth[i], length - slack_m) << "at " << x << ", " << y;
      ASSERT_LE(depth[i], length + inside_m / slant + slack_m) << "at " << x << ", " << y;
      ASSERT_LT(depth[i] / length - 1, GetParam() == 1 ? 1e-4 : 2.5e-4) << "at " << x << ", " << y;
      ASSERT_LT(glm::distance(glm::dvec3(glm::unpackHalf4x16(normal[i])), n), 2e-3)
          << "at " << x << ", " << y;
    }
  }
  EXPECT_GT(compared, 2500u);
}

// A crop of a larger image, drawn by its own camera, equals that part of the image.
TEST_P(Outputs, OffCentreCameraCropsImage) {
  const Stage stage = test::stage();
  const Eye whole = eye_of(stage.scene);
  constexpr glm::uvec2 kFrom{37, 22}, kSize{64, 48};
  Eye piece = whole;
  piece.intrinsics.cx_px -= kFrom.x;
  piece.intrinsics.cy_px -= kFrom.y;
  piece.intrinsics.image_px = kSize;
  settings::DrawSettings settings = with_samples(GetParam());
  settings.post.fxaa = false;  // FXAA reads neighbours
  const state::PoseState poses(stage.scene);
  const Taken large = RenderBench(stage.scene, kExtent, settings).take(poses, view_of(whole), everything());
  const Taken small =
      RenderBench(stage.scene, {kSize.x, kSize.y}, settings).take(poses, view_of(piece), everything());
  const auto large_instance = large.plane<uint32_t>(wire::kInstanceU32);
  const auto small_instance = small.plane<uint32_t>(wire::kInstanceU32);
  const auto large_depth = large.plane<float>(wire::kDepthF32);
  const auto small_depth = small.plane<float>(wire::kDepthF32);
  size_t other_labels = 0, other_colors = 0, other_depths = 0;
  for (uint32_t y = 0; y < kSize.y; ++y) {
    for (uint32_t x = 0; x < kSize.x; ++x) {
      const size_t i = size_t{y} * kSize.x + x, j = size_t{y + kFrom.y} * kExtent.width + x + kFrom.x;
      other_labels += small_instance[i] != large_instance[j] ? 1 : 0;
      other_depths += std::abs(small_depth[i] - large_depth[j]) > 1e-5f * large_depth[j] ? 1 : 0;
      const glm::ivec3 difference =
          glm::abs(pixel(small.image, x, y) - pixel(large.image, x + kFrom.x, y + kFrom.y));
      other_colors += std::max({difference.r, difference.g, difference.b}) > 2 ? 1 : 0;
    }
  }
  // Vertices are snapped to 1/256 pixel, and the two cameras may snap them differently.
  EXPECT_LE(other_labels, 6u);
  EXPECT_LE(other_depths, 12u);
  EXPECT_LE(other_colors, 30u);
}

TEST_F(MoreOutputs, MotionMatchesCameraAndBodies) {
  const Stage before = test::stage();
  std::vector<glm::mat4> poses_now = poses_of(before.scene);
  const Eye eye_before = eye_of(before.scene);
  Eye eye_now = eye_before;
  eye_now.world_from_camera *= glm::rotate(glm::dmat4(1), 0.05, glm::dvec3(0.3, 1, 0.1));
  eye_now.world_from_camera[3] += glm::dvec4(0.1, -0.05, 0.02, 0);
  const glm::dmat4 moved =
      glm::translate(glm::dmat4(1), {0.2, 0.1, 0.05}) * glm::rotate(glm::dmat4(1), 0.1, glm::dvec3(0, 1, 0));
  poses_now[kBox] = glm::mat4(moved) * poses_now[kBox];
  const std::vector<Face> faces_now = faces_of(before.scene, poses_now);
  state::RestPose rest = state::rest_pose(before.scene);
  rest.parent_from_node[kBox] = rest.world_from_node[kBox] = poses_now[kBox];

  RenderBench bench(before.scene, kExtent, with_samples(1));
  state::PoseState poses(before.scene);
  passes::CameraHistory history;
  const glm::vec2 none(0);
  for (int image = 0; image < 2; ++image) {  // the first image, and one without motion
    const Taken taken = bench.take(poses, view_of(eye_before), everything(), &history);
    for (const glm::vec2& motion : taken.plane<glm::vec2>(wire::kMotion)) ASSERT_EQ(motion, none);
  }
  poses.set_rest(rest);
  const Taken taken = bench.take(poses, view_of(eye_now), everything(), &history);
  const auto motion = taken.plane<glm::vec2>(wire::kMotion);
  size_t compared = 0, of_box = 0;
  for (uint32_t y = 0; y < kExtent.height; ++y) {
    for (uint32_t x = 0; x < kExtent.width; ++x) {
      const auto hit = eye_now.cast_surely(faces_now, {x, y});
      if (!hit) continue;
      glm::dvec3 point = hit->point_world;
      if (hit->instance == kBox + 1) point = glm::dvec3(glm::inverse(moved) * glm::dvec4(point, 1));
      if (hit->instance == 0)
        point = glm::dvec3(eye_before.world_from_camera[3]) + 1e9 * eye_now.ray_world({x, y});
      const glm::dvec2 want = glm::dvec2(x, y) - eye_before.project(point);
      const glm::dvec2 got(motion[size_t{y} * kExtent.width + x]);
      ASSERT_LT(glm::distance(want, got), 2e-3) << "at " << x << ", " << y << ", instance " << hit->instance;
      ++compared;
      of_box += hit->instance == kBox + 1 ? 1 : 0;
    }
  }
  EXPECT_GT(compared, size_t{kExtent.width} * kExtent.height * 95 / 100);
  EXPECT_GT(of_box, 100u);
}

// Requested outputs are independent: colours with and without planes, planes with and without colours.
TEST_P(Outputs, PlanesLeaveColoursUnchanged) {
  const Stage stage = test::stage();
  const passes::View view = view_of(eye_of(stage.scene));
  const state::PoseState poses(stage.scene);
  RenderBench bench(stage.scene, kExtent, with_samples(GetParam()));
  const sinks::FrameImage alone = bench.draw(poses, view);
  wire::ImageOutputs outputs = everything();
  outputs.remove(wire::kColorLinearF16);
  const Taken both = bench.take(poses, view, outputs);
  EXPECT_EQ(both.image.rgba8, alone.rgba8);
  outputs.remove(wire::kColorSrgb8);
  const Taken planes = bench.take(poses, view, outputs);
  EXPECT_TRUE(planes.image.rgba8.empty());
  EXPECT_EQ(planes.planes, both.planes);
  EXPECT_EQ(bench.draw(poses, view).rgba8, alone.rgba8);
}

// A plane beside the colours changes none of their bytes. Bright metals and dark edges show whether colours
// come from rounded samples. The materials take the shaders of core materials, of extended ones, and of
// blended draws over compute shading.
TEST_P(Outputs, EveryPairLeavesColoursUnchanged) {
  enum class Contents : uint8_t { opaque, extended, blended };
  for (const Contents contents : {Contents::opaque, Contents::extended, Contents::blended}) {
    SCOPED_TRACE(static_cast<int>(contents));
    SceneBuilder builder;
    scene::Material metal = matte({0.9f, 0.6f, 0.3f});
    metal.metallic = 1;
    metal.roughness = 0.25f;
    if (contents == Contents::extended) metal.clearcoat = 0.5f;
    builder.mesh_node("floor", builder.quad(builder.material(matte({0.4f, 0.45f, 0.5f})), 3), glm::mat4(1));
    builder.mesh_node("ball", builder.sphere(builder.material(metal), 0.8f, 48), at({0, 0.9f, 0}));
    if (contents == Contents::blended) {
      scene::Material film = matte({0.1f, 0.7f, 0.9f});
      film.base_color.a = 0.4f;
      film.alpha_mode = scene::AlphaMode::blend;
      builder.mesh_node("film", builder.box(builder.material(film), {0.3f, 0.3f, 0.3f}), at({1, 0.6f, 0.6f}));
    }
    builder.light_node(sun({1, 0.9f, 0.8f}, 3), shining_towards({-1, -2, -0.5f}));
    builder.camera_node("camera", {0, 1.6f, 4}, {0, 0.7f, 0});
    const scene::Scene scene = builder.build();
    const state::PoseState poses(scene);
    for (const bool fxaa : {false, true}) {
      settings::DrawSettings settings = with_samples(GetParam());
      settings.environment_intensity = 1;
      settings.post.exposure = 1.3f;
      settings.post.fxaa = fxaa;
      RenderBench bench(scene, kExtent, settings);
      const passes::View view = first_camera_view(scene, poses, kExtent);
      const std::vector<uint8_t> alone = bench.draw(poses, view).rgba8;
      for (uint32_t plane = wire::kColorLinearF16; plane <= wire::kMotion; plane <<= 1) {
        const Taken taken = bench.take(poses, view, passes::ImageOutputs(wire::kColorSrgb8 | plane));
        EXPECT_TRUE(taken.image.rgba8 == alone) << "with plane " << plane << ", FXAA " << fxaa;
      }
      EXPECT_TRUE(bench.take(poses, view, everything()).image.rgba8 == alone);
    }
  }
}

TEST_P(Outputs, LinearColoursAreTheLightItself) {
  const Stage stage = test::stage();
  const Eye eye = eye_of(stage.scene);
  const state::PoseState poses(stage.scene);
  settings::DrawSettings settings = with_samples(GetParam());
  settings.post.exposure = 3;
  RenderBench bench(stage.scene, kExtent, settings);
  const sinks::FrameImage alone = bench.draw(poses, view_of(eye));
  const Taken taken = bench.take(poses, view_of(eye), everything());
  const auto linear = taken.plane<uint64_t>(wire::kColorLinearF16);
  size_t compared = 0;
  for (uint32_t y = 0; y < kExtent.height; ++y) {
    for (uint32_t x = 0; x < kExtent.width; ++x) {
      ASSERT_EQ(pixel(taken.image, x, y), pixel(alone, x, y)) << "at " << x << ", " << y;
      const Hit hit = eye.cast(stage.faces, {x, y});
      bool inside = hit.instance != 0;
      for (const glm::dvec2 corner :
           {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(-1, 1), glm::dvec2(1, 1)})
        inside = inside && eye.cast(stage.faces, glm::dvec2(x, y) + 0.51 * corner).instance == hit.instance;
      if (!inside) continue;
      const scene::Mesh& mesh = stage.scene.meshes[stage.scene.nodes[hit.instance - 1].mesh];
      const scene::Material& material =
          stage.scene.materials[stage.scene.primitives[mesh.first_primitive].material];
      const glm::vec4 seen = glm::unpackHalf4x16(linear[size_t{y} * kExtent.width + x]);
      ASSERT_LT(glm::distance(glm::vec3(seen), glm::vec3(material.base_color)), 2e-3f)
          << "at " << x << ", " << y;
      ASSERT_EQ(seen.a, 1);
      ++compared;
    }
  }
  EXPECT_GT(compared, 8000u);
}

// The near and the far plane clip, and an orthographic camera's depth is along its axis, too.
TEST_F(MoreOutputs, NearFarAndOrthographicDepths) {
  const Stage stage = test::stage();
  Eye eye = eye_of(stage.scene);
  eye.intrinsics.near_m = 5;
  eye.intrinsics.far_m = 7;
  const state::PoseState poses(stage.scene);
  RenderBench bench(stage.scene, kExtent, with_samples(1));
  size_t cut = 0;
  for (const float depth : bench.take(poses, view_of(eye), everything()).plane<float>(wire::kDepthF32)) {
    if (std::isinf(depth)) {
      ++cut;
    } else {
      ASSERT_GE(depth, 5 * 0.9999f);
      ASSERT_LE(depth, 7 * 1.0001f);
    }
  }
  EXPECT_GT(cut, 1000u);
  EXPECT_LT(cut, size_t{kExtent.width} * kExtent.height);

  scene::Camera flat;
  flat.orthographic = true;
  flat.half_extent_m = {4, 3};
  const glm::mat4 pose = passes::look_at_pose({0, 4, 4}, {0, 0, 0});
  const passes::View view = passes::make_view(flat, pose, 4.0f / 3);
  const auto depth = bench.take(poses, view, everything()).plane<float>(wire::kDepthF32);
  // A floor pixel at the lower edge: at 45 degrees depth changes as much as the position in the image.
  const double height_m = -(static_cast<double>(118) + 0.5 - 60) / 60 * 3;
  const double expected_m = std::sqrt(32.0) + height_m;
  EXPECT_NEAR(depth[118 * kExtent.width + 80], expected_m, 1e-5 * expected_m);
}

TEST_F(MoreOutputs, BoxesHoldWhatIsSeen) {
  const Stage stage = test::stage();
  const Eye eye = eye_of(stage.scene);
  const state::PoseState poses(stage.scene);
  RenderBench bench(stage.scene, kExtent, with_samples(1));
  const auto instance = bench.take(poses, view_of(eye), everything()).plane<uint32_t>(wire::kInstanceU32);
  const std::vector<wire::BoxRecord3d> known = passes::boxes_of_instances(stage.scene, poses);
  ASSERT_EQ(known.size(), 4u);
  const std::vector<wire::BoxRecord2d> seen = passes::boxes_in_image(instance, kExtent.width, known);
  ASSERT_EQ(seen.size(), 4u);
  for (const wire::BoxRecord2d& box : seen) {
    uint32_t pixels = 0, left = kExtent.width, right = 0, top = kExtent.height, bottom = 0;
    for (uint32_t i = 0; i < instance.size(); ++i) {
      if (instance[i] != box.instance) continue;
      ++pixels;
      left = std::min(left, i % kExtent.width), right = std::max(right, i % kExtent.width + 1);
      top = std::min(top, i / kExtent.width), bottom = std::max(bottom, i / kExtent.width + 1);
    }
    EXPECT_EQ(pixels, box.pixels);
    EXPECT_EQ(std::vector({left, right, top, bottom}),
              std::vector({box.min_x, box.max_x, box.min_y, box.max_y}));
    EXPECT_EQ(box.semantic, stage.scene.nodes[box.instance - 1].semantic);
  }
  const std::vector<wire::BoxRecord3d> boxes = passes::seen_boxes(known, seen);
  ASSERT_EQ(boxes.size(), 4u);
  const glm::mat4& pose = stage.scene.nodes[kBox].world_from_node;
  const std::array<float, 12>& m = boxes[kBox].world_from_box;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      EXPECT_NEAR(m[static_cast<size_t>(4 * row + column)], 2 * kBoxHalf_m[column] * pose[column][row], 1e-6);
    }
    EXPECT_NEAR(m[static_cast<size_t>(4 * row + 3)], pose[3][row], 1e-6);
  }
}

TEST_F(MoreOutputs, NewSceneResetsLabelsAndMotion) {
  const Stage first = test::stage();
  SceneBuilder builder;
  builder.mesh_node("empty", scene::kNone, glm::mat4(1));
  builder.mesh_node("wall", builder.quad(builder.material(glowing({1, 1, 1})), 100), glm::mat4(1));
  builder.camera_node("camera", {0, 3, 6}, {0, 0.8f, 0});
  const scene::Scene second = builder.build();
  const passes::View view = view_of(eye_of(first.scene));
  RenderBench bench(first.scene, kExtent, with_samples(1));
  passes::CameraHistory history;
  bench.take(state::PoseState(first.scene), view, everything(), &history);
  bench.renderer().set_scene(second);
  const Taken taken = bench.take(state::PoseState(second), view, everything(), &history);
  EXPECT_EQ(taken.plane<uint32_t>(wire::kInstanceU32).back(), 2u);
  EXPECT_EQ(taken.plane<glm::vec2>(wire::kMotion).back(), glm::vec2(0));
}

TEST_F(MoreOutputs, ForwardPathReportsNoOutputs) {
  const Stage stage = test::stage();
  settings::DrawSettings settings = with_samples(1);
  settings.raster = settings::RasterPath::forward;
  RenderBench bench(stage.scene, kExtent, settings);
  EXPECT_TRUE(bench.renderer().can_take({}));
  const Result<void> can = bench.renderer().can_take(everything());
  ASSERT_FALSE(can);
  EXPECT_NE(can.error().message.find("--raster forward"), std::string::npos) << can.error().message;
}

TEST_F(MoreOutputs, NothingIsLeftOfThem) {
  const Stage stage = test::stage();
  device().retire_all_now();
  const gpu::LiveObjects before = device().live_objects();
  const uint64_t bytes_before = device().allocated_bytes();
  {
    RenderBench bench(stage.scene, kExtent, with_samples(4));
    passes::CameraHistory history;
    const state::PoseState poses(stage.scene);
    for (const VkExtent2D extent : {kExtent, VkExtent2D{40, 30}, kExtent}) {
      bench.set_size(extent);
      bench.take(poses, view_of(eye_of(stage.scene)), everything(), &history);
    }
  }
  device().retire_all_now();
  EXPECT_EQ(device().live_objects(), before);
  EXPECT_EQ(device().allocated_bytes(), bytes_before);
}

}  // namespace
}  // namespace fire3dv::test
