// Render test of hybrid shadows against ray tracing: a conservative map test never lights a pixel that a ray
// finds in shadow, however thin the occluder. Falsely shadowed pixels occur only in holes narrower than about
// two texels.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

using glm::mat4;
using glm::vec3;

constexpr VkExtent2D kExtent{128, 96};

mat4 scaled(vec3 size) {
  return glm::scale(mat4(1), size);
}
mat4 turned(float angle_rad, vec3 axis) {
  return glm::rotate(mat4(1), angle_rad, glm::normalize(axis));
}

scene::Light lamp(scene::LightType type, float candela) {
  scene::Light light;
  light.type = type;
  light.intensity = candela;
  return light;
}

class ShadowTruth : public ValidationIsSilent {
 protected:
  // Shared by all tests: preparing the environment dominates the cost of a renderer.
  static ProofBench& fine() {
    static ProofBench bench(kExtent, with_fine_maps(shadowed_by(settings::ShadowMethod::ray, true)));
    return bench;
  }
  // Map sizes by image and device; on a CPU device an eighth of the side.
  static ProofBench& usual() {
    static ProofBench bench(kExtent, shadowed_by(settings::ShadowMethod::ray, true));
    return bench;
  }
  static ProofBench& all() {
    static ProofBench bench(kExtent, shadowed_by(settings::ShadowMethod::ray, false));
    return bench;
  }
  static void TearDownTestSuite() { device().retire_all_now(); }

  struct Eye {
    vec3 from, to;
    float fov_rad = 0.7f;
    float near_m = 0.01f;
  };
  // Checks that each pixel in shadow by rays is in shadow. Returns the sums of dark and bright pixels.
  static Brightness expect_never_falsely_lit(const scene::Scene& scene, const std::vector<Eye>& eyes) {
    fine().show(scene);
    usual().show(scene);
    all().show(scene);
    Brightness sum;
    for (const Eye& eye : eyes) {
      SCOPED_TRACE(testing::Message() << "from " << eye.from.x << ", " << eye.from.y << ", " << eye.from.z);
      const sinks::FrameImage by_rays = all().draw(eye.from, eye.to, eye.fov_rad, eye.near_m);
      Brightness seen;
      for (ProofBench* hybrid : {&usual(), &fine()}) {
        SCOPED_TRACE(hybrid == &fine() ? "fine maps" : "usual maps");
        seen = compare_brightness(hybrid->draw(eye.from, eye.to, eye.fov_rad, eye.near_m), by_rays);
        EXPECT_EQ(seen.brighter, 0u) << "last at " << seen.x << ", " << seen.y;
        EXPECT_LE(seen.darker, kExtent.width * kExtent.height / 1000);
      }
      sum.dark += seen.dark;
      sum.bright += seen.bright;
    }
    EXPECT_GT(sum.dark, 20u) << "no shadow to be seen";
    EXPECT_GT(sum.bright, 20u) << "nothing lit to be seen";
    return sum;
  }
};

// Wires of 0.3 mm in all directions, 0.1 to 20 cm above the ground; a texel of a 2048 map is about 3 mm.
void add_wires(SceneBuilder& builder, uint32_t white, float width_m) {
  const uint32_t box = builder.box(white, vec3(0.5f));
  const uint32_t ribbon =
      builder.triangles(white, {{-0.5f, 0, -0.5f}, {-0.5f, 0, 0.5f}, {0.5f, 0, 0.5f}, {0.5f, 0.001f, -0.5f}},
                        {0, 1, 2, 0, 2, 3});
  for (int i = 0; i < 36; ++i) {
    const float angle = 3.14159265f * static_cast<float>(i) / 36;
    const vec3 along(std::cos(angle), 0, std::sin(angle));
    const float height = 0.001f * std::pow(200.0f, static_cast<float>(i % 6) / 5);
    builder.mesh_node("wire" + std::to_string(i), i % 2 ? box : ribbon,
                      at(1.2f * vec3(-along.z, 0, along.x) + vec3(0, height, 0)) * turned(-angle, {0, 1, 0}) *
                          turned(0.02f * static_cast<float>(i % 5), {0, 0, 1}) *
                          scaled({2, width_m, width_m}));
  }
}

scene::Material white_sheet() {
  scene::Material material = matte({1, 1, 1});
  material.double_sided = true;
  return material;
}

TEST_F(ShadowTruth, ThinWiresOverGround) {
  SceneBuilder builder;
  const uint32_t white = builder.material(white_sheet());
  builder.mesh_node("ground", builder.quad(white, 3), mat4(1));
  add_wires(builder, white, 3e-4f);
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({0.4f, -1, 0.3f}));
  const scene::Scene scene = builder.build();
  std::vector<Eye> eyes;
  for (int i = 0; i < 18; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / 18;
    const vec3 place = 1.2f * vec3(-std::sin(angle), 0, std::cos(angle));
    eyes.push_back({place + vec3(0.05f, 0.12f, 0.05f), place});
  }
  expect_never_falsely_lit(scene, eyes);
}

TEST_F(ShadowTruth, ThreadsOverACurvedBody) {
  SceneBuilder builder;
  const uint32_t white = builder.material(white_sheet());
  builder.mesh_node("body",
                    builder.lathe(
                        white,
                        [](float theta, float phi) {
                          return vec3(std::sin(theta) * std::sin(phi), 0.5f * std::cos(theta),
                                      std::sin(theta) * std::cos(phi));
                        },
                        128),
                    at({0, -0.5f, 0}));
  // A bent open sheet, so that the maps contain both its sides.
  std::vector<vec3> positions;
  std::vector<uint32_t> indices;
  for (uint32_t z = 0; z <= 40; ++z) {
    for (uint32_t x = 0; x <= 40; ++x) {
      const float u = static_cast<float>(x) * 0.1f - 2, v = static_cast<float>(z) * 0.1f - 2;
      positions.emplace_back(u, -0.35f + 0.15f * std::sin(2 * u) * std::cos(3 * v), v);
      if (x < 40 && z < 40) {
        const uint32_t a = z * 41 + x;
        for (uint32_t i : {a, a + 41, a + 1, a + 1, a + 41, a + 42}) indices.push_back(i);
      }
    }
  }
  builder.mesh_node("sheet", builder.triangles(white, positions, indices), mat4(1));
  const uint32_t box = builder.box(white, vec3(0.5f));
  for (int i = 0; i < 24; ++i) {
    const float angle = 3.14159265f * static_cast<float>(i) / 24;
    builder.mesh_node("thread" + std::to_string(i), box,
                      at({0, 0.003f * static_cast<float>(i % 4 + 1), 0}) * turned(angle, {0, 1, 0}) *
                          turned(0.1f, {0, 0, 1}) * scaled({4, 3e-4f, 3e-4f}));
  }
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-0.8f, -1, 0.5f}));
  const scene::Scene scene = builder.build();
  std::vector<Eye> eyes;
  for (int i = 0; i < 12; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / 12;
    const vec3 place(0.35f * std::cos(angle), 0, 0.35f * std::sin(angle));
    eyes.push_back({place + vec3(0.03f, 0.2f, 0.06f), place});
    eyes.push_back({3.0f * place + vec3(0.03f, 0.3f, 0.06f), 3.0f * place});
  }
  expect_never_falsely_lit(scene, eyes);
}

TEST_F(ShadowTruth, NeedlesRestOnASurface) {
  SceneBuilder builder;
  const uint32_t white = builder.material(white_sheet());
  builder.mesh_node("ground", builder.quad(white, 0.5f), mat4(1));
  // A solid table beside it casts a shadow; its top is in no map.
  builder.mesh_node("table", builder.box(white, {0.25f, 0.05f, 0.25f}), at({0.5f, 0.0501f, 0}));
  const uint32_t needle = builder.lathe(
      white,
      [](float theta, float phi) {
        const float r = 5e-4f * std::sin(theta);  // 1 mm thick, 60 mm long, pointed
        return vec3(0.03f * std::cos(theta), r * std::sin(phi), r * std::cos(phi));
      },
      16);
  for (int i = 0; i < 12; ++i) {
    const float angle = 3.14159265f * static_cast<float>(i) / 12;
    const vec3 side(std::cos(angle) * 0.2f, 0, std::sin(angle) * 0.2f);
    builder.mesh_node("needle" + std::to_string(i), needle,
                      at(side + vec3(-0.1f, 5e-4f, 0)) * turned(angle * 5, {0, 1, 0}));
    builder.mesh_node("on_table" + std::to_string(i), needle,
                      at(side + vec3(0.5f, 0.1001f + 5e-4f, 0)) * turned(angle * 3, {0, 1, 0}));
  }
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-0.5f, -1, 0.2f}));
  const scene::Scene scene = builder.build();
  std::vector<Eye> eyes;
  for (int i = 0; i < 12; ++i) {
    const float angle = 3.14159265f * static_cast<float>(i) / 12;
    const vec3 place(std::cos(angle) * 0.2f - 0.1f, 0, std::sin(angle) * 0.2f);
    eyes.push_back({place + vec3(0.02f, 0.06f, 0.03f), place});
    eyes.push_back({place + vec3(0.62f, 0.16f, 0.03f), place + vec3(0.6f, 0.1f, 0)});
  }
  expect_never_falsely_lit(scene, eyes);
}

TEST_F(ShadowTruth, RibbonsJustAboveASlope) {
  SceneBuilder builder;
  const uint32_t white = builder.material(white_sheet());
  // Bent by a millimetre, so that it is no planar caster.
  const uint32_t slope =
      builder.triangles(white, {{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}, {0, 0.001f, 0}},
                        {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4});
  const mat4 tilt = turned(1.2f, {0, 0, 1});
  builder.mesh_node("slope", slope, tilt);
  const uint32_t ribbon =
      builder.triangles(white, {{-0.5f, 0, -0.5f}, {-0.5f, 0, 0.5f}, {0.5f, 0, 0.5f}, {0.5f, 0.001f, -0.5f}},
                        {0, 1, 2, 0, 2, 3});
  for (int i = 0; i < 20; ++i) {
    const float gap = 0.0005f * static_cast<float>(i + 4);
    builder.mesh_node("ribbon" + std::to_string(i), ribbon,
                      tilt * at({0, gap, -0.9f + 0.09f * static_cast<float>(i)}) *
                          turned(0.3f * static_cast<float>(i), {0, 1, 0}) * scaled({0.08f, 1, 0.002f}));
  }
  builder.light_node(sun({1, 1, 1}, 5), shining_towards({0.1f, -1, 0.05f}));  // nearly along the slope
  const scene::Scene scene = builder.build();
  std::vector<Eye> eyes;
  const vec3 normal = vec3(tilt * glm::vec4(0, 1, 0, 0));
  for (int i = 0; i < 20; ++i) {
    const vec3 place(tilt * glm::vec4(0, 0, -0.9f + 0.09f * static_cast<float>(i), 1));
    eyes.push_back({place + 0.15f * normal + vec3(0, 0.02f, 0.01f), place});
  }
  expect_never_falsely_lit(scene, eyes);
}

// A closed room whose walls are seen from inside: no sunlight enters.
scene::Scene room(bool with_lamp) {
  SceneBuilder builder;
  const uint32_t white = builder.material(white_sheet());
  builder.mesh_node("room", builder.box(white, {1, 1, 1}), mat4(1));
  builder.mesh_node("outside", builder.box(white, {0.3f, 0.3f, 0.3f}), at({2.5f, 0, 0}));
  // A closed ball: its lit side is in no map and hides no map data.
  builder.mesh_node("ball",
                    builder.lathe(
                        white,
                        [](float theta, float phi) {
                          return 0.2f * vec3(std::sin(theta) * std::sin(phi), std::cos(theta),
                                             std::sin(theta) * std::cos(phi));
                        },
                        32),
                    at({0.3f, -0.5f, 0.2f}));
  if (with_lamp) builder.light_node(lamp(scene::LightType::point, 3), at({0.1f, 0.3f, 0.1f}));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-0.6f, -1, 0.2f}));
  return builder.build();
}

TEST_F(ShadowTruth, InsideAClosedRoom) {
  const scene::Scene with_lamp = room(true);
  expect_never_falsely_lit(with_lamp, {{{0, 0, 0}, {1, -0.4f, 0}},
                                       {{-0.9f, 0.5f, 0.9f}, {0.3f, -0.5f, 0}},
                                       {{0.9f, 0.9f, 0.9f}, {-1, -1, -1}},
                                       {{4, 1, 1}, {2.5f, 0, 0}}});
}

// The near plane cuts the wall away: the camera sees the inside of a closed mesh from an eye outside of it.
TEST_F(ShadowTruth, NearPlaneCutsMesh) {
  const scene::Scene dark_room = room(false);
  expect_never_falsely_lit(dark_room, {{{0, 0, 3}, {0, 0, 0}, 0.7f, 2.3f},
                                       {{1.8f, 1.2f, 1.8f}, {0, -0.4f, 0}, 1.2f, 1.6f},
                                       {{0, 1.78f, 0}, {0, 0, 0}, 0.9f, 0.9f},
                                       {{5, 1, 1}, {2.5f, 0, 0}}});
}

TEST_F(ShadowTruth, ParallelViewNearPlaneCutsClosedMesh) {
  const scene::Scene dark_room = room(false);
  usual().show(dark_room);
  fine().show(dark_room);
  all().show(dark_room);
  scene::Camera camera;
  camera.orthographic = true;
  camera.half_extent_m = {3, 3};
  camera.near_m = 0.01f;
  // The eye is beside the room; the near plane through it cuts the room.
  for (const vec3 eye : {vec3(0, 2.5f, 0), vec3(2.4f, 1.2f, 0.1f), vec3(0, 0, 4)}) {
    const mat4 pose = passes::look_at_pose(eye, eye - vec3(0, 0, 1));
    for (ProofBench* hybrid : {&usual(), &fine()}) {
      const Brightness seen = compare_brightness(hybrid->draw(camera, pose), all().draw(camera, pose));
      EXPECT_EQ(seen.brighter, 0u) << "last at " << seen.x << ", " << seen.y;
      EXPECT_GT(seen.bright + seen.dark, 0u);
    }
  }
}

TEST_F(ShadowTruth, PointLightCoversAllDirections) {
  SceneBuilder builder;
  const uint32_t white = builder.material(white_sheet());
  scene::Material inside = white_sheet();
  builder.mesh_node("room", builder.box(builder.material(inside), {1.5f, 1.3f, 1.1f}), mat4(1));
  const uint32_t box = builder.box(white, vec3(0.5f));
  for (int i = 0; i < 60; ++i) {  // a nest of wires around the lamp
    const float k = static_cast<float>(i) + 0.5f;
    const float y = 1 - 2 * k / 60, r = std::sqrt(1 - y * y), angle = 2.3999632f * k;
    const vec3 direction(r * std::cos(angle), y, r * std::sin(angle));
    builder.mesh_node("thread" + std::to_string(i), box,
                      at(0.4f * direction + vec3(0.1f, 0.05f, -0.1f)) * turned(angle, direction) *
                          turned(1.1f * k, {1, 2, 3}) * scaled({0.6f, 3e-4f, 3e-4f}));
  }
  builder.light_node(lamp(scene::LightType::point, 4), at({0.1f, 0.05f, -0.1f}));
  const scene::Scene scene = builder.build();
  std::vector<Eye> eyes;
  for (const vec3 direction :
       {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0), vec3(0, 0, 1), vec3(0, 0, -1)}) {
    eyes.push_back({vec3(0.05f, 0.02f, 0.02f), direction, 1.2f});
  }
  for (float x : {-1.0f, 1.0f}) {  // at the seams of the cube map
    for (float y : {-1.0f, 1.0f}) {
      eyes.push_back({vec3(0.05f, 0.02f, 0.02f), {x, y, 0.1f}, 0.6f});
      eyes.push_back({vec3(0.05f, 0.02f, 0.02f), {0.1f, x, y}, 0.6f});
    }
  }
  expect_never_falsely_lit(scene, eyes);
}

TEST_F(ShadowTruth, SpotLightsNarrowAndWide) {
  for (float cone_rad : {0.3f, 1.1f, 1.5f}) {
    SCOPED_TRACE(cone_rad);
    SceneBuilder builder;
    const uint32_t white = builder.material(white_sheet());
    builder.mesh_node("ground", builder.quad(white, 3), mat4(1));
    add_wires(builder, white, 3e-4f);
    scene::Light spot = lamp(scene::LightType::spot, 6);
    spot.outer_cone_rad = cone_rad;
    spot.inner_cone_rad = 0.9f * cone_rad;
    builder.light_node(spot, shining_towards({0.1f, -1, 0.25f}, {0.8f, 0.6f, 0.2f}));
    const scene::Scene scene = builder.build();
    expect_never_falsely_lit(scene, {{{1.1f, 0.2f, 0.5f}, {1.0f, 0, 0.4f}},
                                     {{0.9f, 0.15f, 0.9f}, {0.9f, 0, 0.8f}},
                                     {{0.5f, 0.5f, 0.5f}, {0.9f, 0, 0.4f}, 1.2f},
                                     {{0.1f, 0.2f, 1.3f}, {0, 0, 1.2f}}});
  }
}

// Near the terminator a smooth normal sees a light below its triangle's horizon: the ray starts inside of the
// ball. Of 4 samples, so that edge pixels evaluate triangles beside their borders, too.
TEST_F(ShadowTruth, SmoothBallsOfFewFacets) {
  SceneBuilder builder;
  scene::Material coated = matte({0.8f, 0.8f, 0.8f});
  coated.clearcoat = 0.3f;  // light counts from all sides of its normal map
  const uint32_t gray = builder.material(matte({0.6f, 0.6f, 0.6f}));
  builder.mesh_node("ground", builder.quad(gray, 3), mat4(1));
  const uint32_t balls[2] = {builder.sphere(gray, 0.25f, 16),
                             builder.sphere(builder.material(coated), 0.25f, 16)};
  for (int i = 0; i < 5; ++i)
    builder.mesh_node("ball" + std::to_string(i), balls[i % 2],
                      at({0.55f * static_cast<float>(i - 2), 0.25f, 0.2f * static_cast<float>(i % 3)}));
  for (int i = 0; i < 6; ++i) {
    const float angle = static_cast<float>(i);
    const vec3 from(2 * std::cos(angle), 0.8f + 0.2f * static_cast<float>(i), 2 * std::sin(angle));
    scene::Light light = lamp(i % 2 ? scene::LightType::point : scene::LightType::spot, 3);
    light.outer_cone_rad = 0.9f;
    light.inner_cone_rad = 0.5f;
    builder.light_node(light, shining_towards(-from, from));
  }
  builder.camera_node("camera", {0, 1.3f, 2.6f}, {0, 0.2f, 0}, 0.8f);
  const scene::Scene scene = builder.build();
  const state::PoseState poses(scene);
  const passes::ImageOutputs outputs(wire::kColorLinearF16);
  std::vector<uint64_t> light[2];
  for (const bool hybrid : {false, true}) {
    RenderBench bench(scene, kExtent, shadowed_by(settings::ShadowMethod::ray, hybrid, 4));
    light[hybrid ? 1 : 0] = bench.take(poses, first_camera_view(scene, poses, kExtent), outputs)
                                .plane<uint64_t>(wire::kColorLinearF16);
  }
  size_t darker = 0;
  for (size_t i = 0; i < light[0].size(); ++i) {
    const vec3 by_rays(glm::unpackHalf4x16(light[0][i])), seen(glm::unpackHalf4x16(light[1][i]));
    EXPECT_TRUE(glm::all(glm::lessThanEqual(seen, by_rays)))
        << "at " << i % kExtent.width << ", " << i / kExtent.width;
    darker += seen != by_rays ? 1 : 0;
  }
  EXPECT_LE(darker, light[0].size() / 1000);
}

// A scene of a few metres at kilometres from the world's origin, as in georeferenced scenes.
TEST_F(ShadowTruth, FarFromTheOrigin) {
  for (const vec3 far : {vec3(200, 0, 0), vec3(3000, 500, -2000)}) {
    SCOPED_TRACE(far.x);
    SceneBuilder builder;
    const uint32_t white = builder.material(white_sheet());
    builder.mesh_node("ground", builder.quad(white, 3), at(far));
    const uint32_t box = builder.box(white, vec3(0.5f));
    for (int i = 0; i < 24; ++i) {
      const float angle = 3.14159265f * static_cast<float>(i) / 24;
      builder.mesh_node(
          "wire" + std::to_string(i), box,
          at(far + vec3(0, 0.004f + 0.01f * static_cast<float>(i), 0.02f * static_cast<float>(i))) *
              turned(angle, {0, 1, 0}) * scaled({3, 0.002f, 0.002f}));
    }
    builder.light_node(sun({1, 1, 1}, 3), shining_towards({0.4f, -1, 0.3f}));
    scene::Light spot = lamp(scene::LightType::spot, 20);
    builder.light_node(spot, shining_towards({-0.1f, -1, 0.1f}, far + vec3(0.5f, 2, 0.2f)));
    const scene::Scene scene = builder.build();
    std::vector<Eye> eyes;
    for (int i = 0; i < 8; ++i) {
      const float angle = 6.2831853f * static_cast<float>(i) / 8;
      const vec3 place = far + 0.7f * vec3(std::cos(angle), 0, std::sin(angle));
      eyes.push_back({place + vec3(0.2f, 0.5f, 0.2f), place});
    }
    expect_never_falsely_lit(scene, eyes);
  }
}

}  // namespace
}  // namespace fire3dv::test
