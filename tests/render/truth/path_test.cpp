// Render tests of the path tracer against closed forms, the raster and itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <string>

#include "renderer/scene/textures/environment.h"
#include "tests/render/support/path_bench.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/render/support/truth_scenes.h"

namespace fire3dv::test {
namespace {

class Paths : public ValidationIsSilent {};

TEST_F(Paths, WhiteFurnaceHidesWhiteSurfaces) {
  struct Surface {
    std::string name;
    scene::Material material;
    double least, most;  // as in docs/design/materials.md
  };
  for (const float roughness : {0.0f, 0.3f, 1.0f}) {
    std::vector<Surface> surfaces;
    const auto add = [&](const std::string& name, float metallic, double least,
                         double most) -> scene::Material& {
      scene::Material material = matte(glm::vec3(1));
      material.metallic = metallic;
      material.roughness = roughness;
      surfaces.push_back({name + ", roughness " + std::to_string(roughness), material, least, most});
      return surfaces.back().material;
    };
    add("metal", 1, 0.99, 1.005);
    add("dielectric", 0, 0.99, 1.005);
    add("transmission", 0, 0.99, 1.005).transmission = 1;
    scene::Material& coated = add("clearcoat", 0, 0.98, 1.005);
    coated.clearcoat = 1;
    coated.clearcoat_roughness = 0.2f;
    scene::Material& cloth = add("sheen", 0, 0.97, 1.01);
    cloth.sheen_color = glm::vec3(1);
    cloth.sheen_roughness = 0.5f;
    for (const float degrees : {15.0f, 70.0f}) {
      // The tiles lie side by side, seen from far away in one direction.
      constexpr float kDistance = 1000;
      constexpr uint32_t kTile = 16;
      SceneBuilder builder;
      const auto count = static_cast<uint32_t>(surfaces.size());
      for (uint32_t i = 0; i < count; ++i)
        builder.mesh_node(surfaces[i].name, builder.quad(builder.material(surfaces[i].material), 1),
                          at({2 * static_cast<float>(i) - static_cast<float>(count - 1), 0, 0}) *
                              glm::scale(glm::mat4(1), glm::vec3(1, 1, 5)));
      const float angle = glm::radians(degrees);
      builder.camera_node("camera", kDistance * glm::vec3(0, std::cos(angle), std::sin(angle)), {0, 0, 0},
                          2 * std::atan(1 / kDistance));
      settings::DrawSettings settings = path_settings(64, 2);
      settings.environment = constant_environment(glm::vec3(0.5f));
      settings.environment_intensity = 2;
      const std::vector<glm::dvec3> pixels = linear_image(builder.build(), {kTile * count, kTile}, settings);
      for (uint32_t i = 0; i < count; ++i) {
        std::vector<glm::dvec3> tile;
        for (uint32_t y = 1; y + 1 < kTile; ++y)
          for (uint32_t x = 1; x + 1 < kTile; ++x)
            tile.push_back(pixels[(size_t{y} * count + i) * kTile + x]);
        const Estimate seen = estimate(tile);
        const std::string what = surfaces[i].name + ", " + std::to_string(degrees) + " degrees";
        RecordProperty(what, std::to_string(seen.mean) + " +- " + std::to_string(seen.error));
        EXPECT_GE(seen.mean, surfaces[i].least - 4 * seen.error) << what;
        EXPECT_LE(seen.mean, surfaces[i].most + 4 * seen.error) << what;
        EXPECT_LT(seen.error, 0.007) << what;
      }
    }
  }
}

TEST_F(Paths, DiffusePlaneReflectsAlbedo) {
  SceneBuilder builder;
  builder.mesh_node("plane", builder.quad(builder.material(lambert({0.2f, 0.5f, 0.8f})), 100), glm::mat4(1));
  builder.camera_node("camera", {0, 2, 2}, {0, 0, 0});
  settings::DrawSettings settings = path_settings(256, 0);
  settings.environment = constant_environment(glm::vec3(3));
  settings.environment_intensity = 1;
  const std::vector<glm::dvec3> pixels = linear_image(builder.build(), {16, 16}, settings);
  expect_equal(estimate(pixels, 0), 0.6, "albedo 0.2");
  expect_equal(estimate(pixels, 1), 1.5, "albedo 0.5");
  expect_equal(estimate(pixels, 2), 2.4, "albedo 0.8");
}

// A small sun in a dark sky, by quadrature of the image as it is shown: bilinear between texels.
TEST_F(Paths, SunInEnvironmentLightsPlane) {
  const uint32_t width = 64, height = 32;
  const glm::vec3 towards_sun = glm::normalize(glm::vec3(0.4f, 0.8f, -0.3f));
  const auto image = std::make_shared<scene::EnvironmentImage>(
      scene::make_environment(width, height, [&](const glm::vec3& direction) {
        return glm::vec3(glm::dot(direction, towards_sun) > 0.995f ? 1000.0f : 0.1f);
      }));
  const auto texel = [&](int x, int y) {
    x = (x + static_cast<int>(width)) % static_cast<int>(width);
    y = std::clamp(y, 0, static_cast<int>(height) - 1);
    return image->scale *
           scene::unpack_rgb9e5(image->rgb9e5[static_cast<size_t>(y) * width + static_cast<size_t>(x)]).g;
  };
  double irradiance = 0;
  constexpr int kSteps = 16;  // along a texel
  for (int j = 0; j < static_cast<int>(height) / 2 * kSteps; ++j) {
    const double v = (j + 0.5) / (height * kSteps), angle = kPi * v;
    for (int i = 0; i < static_cast<int>(width) * kSteps; ++i) {
      const double x = (i + 0.5) / kSteps - 0.5, y = v * height - 0.5;
      const double fx = x - std::floor(x), fy = y - std::floor(y);
      const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
      const double radiance = (1 - fy) * ((1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0)) +
                              fy * ((1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1));
      irradiance += radiance * std::cos(angle) * std::sin(angle) * 2 * kPi * kPi /
                    (double(width) * height * kSteps * kSteps);
    }
  }
  SceneBuilder builder;
  builder.mesh_node("plane", builder.quad(builder.material(lambert(glm::vec3(0.5f))), 100), glm::mat4(1));
  builder.camera_node("camera", {0, 2, 2}, {0, 0, 0});
  settings::DrawSettings settings = path_settings(64, 0);
  settings.environment = image;
  settings.environment_intensity = 1;
  settings.environment_rotation_rad = 0.7f;  // the plane does not care
  expect_equal(estimate(linear_image(builder.build(), {16, 16}, settings)), 0.5 * irradiance / kPi, "sun");
}

scene::Scene glossy_ball(bool smooth) {
  SceneBuilder builder;
  scene::Material ball = matte({0.8f, 0.4f, 0.2f});
  ball.roughness = smooth ? 0.4f : 0.8f;
  ball.metallic = smooth ? 1.0f : 0.0f;
  builder.mesh_node("ball", builder.sphere(builder.material(ball), 0.5f), at({0, 0.5f, 0}));
  builder.mesh_node("floor", builder.quad(builder.material(matte({0.5f, 0.5f, 0.6f})), 3), glm::mat4(1));
  scene::Light bulb;
  bulb.intensity = 20;
  builder.light_node(bulb, at({1.5f, 2.5f, 1}));
  builder.light_node(sun({1, 0.9f, 0.8f}, 2), shining_towards({-0.5f, -1, -0.3f}));
  builder.camera_node("camera", {0.5f, 1.6f, 3}, {0, 0.4f, 0});
  return builder.build();
}

// A leaf seen from below, lit from both sides, with the shadow of a ball above it.
scene::Scene lit_leaf(const scene::Material& leaf) {
  SceneBuilder builder;
  builder.mesh_node("leaf", builder.quad(builder.material(leaf), 1.5f), glm::mat4(1));
  builder.mesh_node("ball", builder.sphere(builder.material(matte({0.5f, 0.5f, 0.6f})), 0.2f),
                    at({0.3f, 0.4f, 0.1f}));
  scene::Light bulb;
  bulb.intensity = 10;
  builder.light_node(bulb, at({0.5f, 1.5f, 0.6f}));
  builder.light_node(bulb, at({-0.5f, -2, 0.3f}));
  builder.light_node(sun({1, 0.9f, 0.8f}, 2), shining_towards({-0.5f, -1, -0.3f}));
  builder.camera_node("camera", {0.5f, -2.5f, 1.5f}, {0, 0, 0}, 0.6f);
  return builder.build();
}

// Compares direct light of both renderers at pixels off edges of shapes and shadows, where the neighbours
// differ by a smooth gradient only.
void expect_raster(const scene::Scene& scene, uint32_t least_compared, double mean_tolerance,
                   const std::string& what) {
  const VkExtent2D extent{48, 48};
  settings::DrawSettings raster = path_settings(1, 0);
  raster.path.reset();
  raster.shadows.method = settings::ShadowMethod::ray;
  raster.shadows.hybrid = false;
  const std::vector<glm::dvec3> drawn = linear_image(scene, extent, raster);
  const std::vector<glm::dvec3> traced = linear_image(scene, extent, path_settings(256, 0));
  uint32_t compared = 0;
  double sum_drawn = 0, sum_traced = 0, largest = 0;
  for (uint32_t y = 1; y + 1 < extent.height; ++y) {
    for (uint32_t x = 1; x + 1 < extent.width; ++x) {
      double least = 1e9, most = 0;
      for (uint32_t i = 0; i < 9; ++i) {
        const double green = drawn[size_t{y - 1 + i / 3} * extent.width + x - 1 + i % 3].g;
        least = std::min(least, green);
        most = std::max(most, green);
      }
      const size_t at = size_t{y} * extent.width + x;
      // A sample pattern may miss slivers that an area does not.
      if (most == 0) {
        EXPECT_LT(traced[at].g, 0.02) << x << ", " << y << ", " << what;
      }
      if (least < 0.02 || most > 1.08 * least) continue;
      ++compared;
      sum_drawn += drawn[at].g;
      sum_traced += traced[at].g;
      for (int c = 0; c < 3; ++c) {
        const double ratio = traced[at][c] / drawn[at][c];
        largest = std::max(largest, std::abs(ratio - 1));
        EXPECT_NEAR(ratio, 1, 0.005) << x << ", " << y << ", channel " << c << ", " << what;
      }
    }
  }
  EXPECT_GT(compared, least_compared) << what;
  EXPECT_NEAR(sum_traced / sum_drawn, 1, mean_tolerance) << what;
  testing::Test::RecordProperty(what + ", largest difference", std::to_string(largest));
}

TEST_F(Paths, DirectLightEqualsRasterOffEdges) {
  expect_raster(glossy_ball(false), 700, 5e-4, "plastic");
  expect_raster(glossy_ball(true), 700, 5e-4, "metal");
  scene::Scene brushed = glossy_ball(true);
  for (scene::Material& material : brushed.materials) {
    material.anisotropy = 0.7f;
    material.anisotropy_rotation_rad = 0.5f;
  }
  expect_raster(brushed, 600, 5e-4, "anisotropic metal and plastic");
  scene::Scene filmed = glossy_ball(true);
  for (scene::Material& material : filmed.materials) {
    material.iridescence = 0.8f;
    material.iridescence_ior = 1.7f;
  }
  expect_raster(filmed, 600, 5e-4, "iridescent metal and plastic");

  scene::Material leaf = matte({0.4f, 0.7f, 0.3f});
  leaf.double_sided = true;
  leaf.diffuse_transmission = 0.6f;
  leaf.diffuse_transmission_color = {0.9f, 0.8f, 0.3f};
  expect_raster(lit_leaf(leaf), 600, 5e-4, "leaf");
  scene::Material coated = leaf, cloth = leaf;
  coated.clearcoat = 0.8f;
  coated.clearcoat_roughness = 0.5f;
  expect_raster(lit_leaf(coated), 600, 5e-4, "coated leaf");
  cloth.sheen_color = {0.8f, 0.6f, 0.9f};
  cloth.sheen_roughness = 0.5f;
  cloth.metallic = 0.4f;
  expect_raster(lit_leaf(cloth), 600, 5e-4, "cloth that light passes");
}

// The near plane cuts the ball, the far plane the floor.
TEST_F(Paths, CamerasAreThoseOfTheRaster) {
  scene::Scene scene = glossy_ball(false);
  scene.cameras[0].near_m = 2.9f;
  scene.cameras[0].far_m = 4.4f;
  expect_raster(scene, 150, 2e-3, "perspective between planes");
  scene.cameras[0].orthographic = true;
  scene.cameras[0].half_extent_m = {1.4f, 1.4f};
  expect_raster(scene, 30, 2e-3, "orthographic between planes");
}

// A convex object hides nothing of its surroundings from itself. The raster's prefiltered environment is an
// approximation (split sum), which the means of the image keep.
TEST_F(Paths, EnvironmentMatchesRasterOnAverage) {
  const struct {
    float metallic, roughness;
    double tolerance;
  } cases[] = {{1, 0.1f, 0.02}, {0, 0.3f, 0.02}, {1, 0.6f, 0.05}, {0, 1, 0.05}};
  for (const auto& each : cases) {
    SceneBuilder builder;
    scene::Material material = matte(glm::vec3(0.8f));
    material.metallic = each.metallic;
    material.roughness = each.roughness;
    builder.mesh_node("ball", builder.sphere(builder.material(material), 1, 128), glm::mat4(1));
    builder.camera_node("camera", {0, 1, 3}, {0, 0, 0});
    const scene::Scene scene = builder.build();
    settings::DrawSettings settings = path_settings(64, 0);
    settings.environment_intensity = 1;  // of the studio
    const double traced = estimate(linear_image(scene, {48, 48}, settings)).mean;
    settings.path.reset();
    const double drawn = estimate(linear_image(scene, {48, 48}, settings)).mean;
    const std::string what =
        "metallic " + std::to_string(each.metallic) + ", roughness " + std::to_string(each.roughness);
    RecordProperty(what, std::to_string(traced / drawn));
    EXPECT_NEAR(traced / drawn, 1, each.tolerance) << what;
  }
}

// L after b bounces = I / (pi R^2) * sum of albedo^k, k = 1 .. b + 1.
TEST_F(Paths, IntegratingSphereShowsGeometricSeries) {
  const scene::Scene scene = integrating_sphere(128);
  for (const auto& [bounces, series] : {std::pair(0u, 0.5), {1u, 0.75}, {3u, 0.9375}, {64u, 1.0}}) {
    expect_equal(estimate(linear_image(scene, {16, 16}, path_settings(128, bounces))), 10 / kPi * series,
                 std::to_string(bounces) + " bounces");
  }
}

// Error of a pixel against the closed form.
TEST_F(Paths, ErrorFallsWithRootOfSamples) {
  const scene::Scene scene = integrating_sphere(128);
  const double few = estimate(linear_image(scene, {32, 32}, path_settings(16, 64))).deviation;
  const double many = estimate(linear_image(scene, {32, 32}, path_settings(64, 64, 2))).deviation;
  EXPECT_GT(few, 0.01);
  EXPECT_NEAR(many / few, 0.5, 0.06);
}

// A closed cube of side 1 with a lamp of side 0.5 in its ceiling. Truths: direct light is exact; all bounces
// from a radiosity solution (6 x 40 x 40 patches, extrapolated) and Cycles, which agree to 0.2 %.
scene::Scene cornell_cube(glm::vec3 eye, glm::vec3 target) {
  SceneBuilder builder;
  const auto wall = [&](glm::vec3 albedo) { return builder.material(lambert(albedo)); };
  const glm::vec3 gray(0.75f);
  const auto turned = [](float degrees, glm::vec3 axis, glm::vec3 where) {
    return at(where) * glm::rotate(glm::mat4(1), glm::radians(degrees), axis);
  };
  builder.mesh_node("floor", builder.quad(wall(gray), 0.5f), at({0.5f, 0, 0.5f}));
  builder.mesh_node("ceiling", builder.quad(wall(gray), 0.5f), turned(180, {1, 0, 0}, {0.5f, 1, 0.5f}));
  builder.mesh_node("back", builder.quad(wall(gray), 0.5f), turned(90, {1, 0, 0}, {0.5f, 0.5f, 0}));
  builder.mesh_node("front", builder.quad(wall(gray), 0.5f), turned(-90, {1, 0, 0}, {0.5f, 0.5f, 1}));
  builder.mesh_node("left", builder.quad(wall({0.75f, 0.25f, 0.25f}), 0.5f),
                    turned(-90, {0, 0, 1}, {0, 0.5f, 0.5f}));
  builder.mesh_node("right", builder.quad(wall({0.25f, 0.75f, 0.25f}), 0.5f),
                    turned(90, {0, 0, 1}, {1, 0.5f, 0.5f}));
  scene::Material lamp = lambert(gray);
  lamp.emissive = glm::vec3(1);
  builder.mesh_node("lamp", builder.quad(builder.material(lamp), 0.25f),
                    turned(180, {1, 0, 0}, {0.5f, 0.9999f, 0.5f}));
  builder.camera_node("camera", eye, target, 0.01f);
  return builder.build();
}

TEST_F(Paths, ACornellCubeShowsItsRadiosity) {
  const VkExtent2D extent{16, 16};
  const glm::vec3 middle(0.5f);
  const auto colors = [&](glm::vec3 target, uint32_t bounces, uint32_t samples) {
    return linear_image(cornell_cube(middle, target), extent, path_settings(samples, bounces));
  };
  expect_equal(estimate(colors({0.5f, 0, 0.5f}, 0, 2048), 0), 0.05511, "floor, direct");
  const std::vector<glm::dvec3> floor = colors({0.5f, 0, 0.5f}, 64, 1024);
  expect_equal(estimate(floor, 0), 0.1135, "floor, red");
  expect_equal(estimate(floor, 2), 0.0928, "floor, blue");
  const std::vector<glm::dvec3> left = colors({0, 0.5f, 0.5f}, 64, 1024);
  expect_equal(estimate(left, 0), 0.1132, "left, red");
  expect_equal(estimate(left, 1), 0.0412, "left, green");
}

// The irradiance of a spherical lamp above the horizon does not depend on its radius.
TEST_F(Paths, BallLampLightsAsPoint) {
  for (const float radius : {0.0f, 0.1f, 0.6f}) {
    SceneBuilder builder;
    builder.mesh_node("plane", builder.quad(builder.material(lambert(glm::vec3(0.5f))), 10), glm::mat4(1));
    scene::Light bulb;
    bulb.intensity = 10;
    bulb.radius_m = radius;
    builder.light_node(bulb, at({0, 1, 0}));
    builder.camera_node("camera", {0, 3, 0.1f}, {0, 0, 0}, 0.01f);
    expect_equal(estimate(linear_image(builder.build(), {16, 16}, path_settings(64, 0))), 10 * 0.5 / kPi,
                 "radius " + std::to_string(radius));
  }
}

// More lamps than a path samples: the strata of the list are unbiased.
TEST_F(Paths, ManyLampsAddUp) {
  SceneBuilder builder;
  builder.mesh_node("plane", builder.quad(builder.material(lambert(glm::vec3(0.5f))), 10), glm::mat4(1));
  double irradiance = 0;
  for (int i = 0; i < 21; ++i) {
    builder.light_node(sun(glm::vec3(1), 0.1f * static_cast<float>(i + 1)), shining_towards({0.2f, -1, 0}));
    irradiance += 0.1 * (i + 1) / std::sqrt(1.04);
  }
  builder.camera_node("camera", {0, 2, 2}, {0, 0, 0});
  expect_equal(estimate(linear_image(builder.build(), {16, 16}, path_settings(64, 0))),
               0.5 * irradiance / kPi, "21 suns");
}

// A blended sheet lets the complement of its alpha pass, to the eye and to lamps; a masked one all or
// nothing.
TEST_F(Paths, AlphaAttenuates) {
  const struct {
    scene::AlphaMode mode;
    float alpha;
    double passes;
  } cases[] = {{scene::AlphaMode::blend, 0.3f, 0.7},
               {scene::AlphaMode::mask, 0.3f, 1},
               {scene::AlphaMode::mask, 0.7f, 0}};
  for (const auto& each : cases) {
    SceneBuilder builder;
    scene::Material sheet = lambert(glm::vec3(0));
    sheet.base_color.a = each.alpha;
    sheet.alpha_mode = each.mode;
    builder.mesh_node("sheet", builder.quad(builder.material(sheet), 5), at({0, 1, 0}));
    builder.mesh_node("plane", builder.quad(builder.material(lambert(glm::vec3(0.5f))), 10), glm::mat4(1));
    builder.light_node(sun(glm::vec3(1), 4), shining_towards({0, -1, 0.1f}));
    builder.camera_node("camera", {0, 3, 0.1f}, {0, 0, 0});
    const double open = 0.5 * 4 / std::sqrt(1.01) / kPi;
    const Estimate seen = estimate(linear_image(builder.build(), {16, 16}, path_settings(256, 0)));
    EXPECT_NEAR(seen.mean, open * each.passes * each.passes, 4 * seen.error + 0.005 * open) << each.alpha;
  }
}

// Single-sided surfaces are invisible from behind to the camera, and opaque to all other rays.
TEST_F(Paths, CameraSeesThroughSingleSidedBacks) {
  for (const bool faces_up : {false, true}) {
    SceneBuilder builder;
    scene::Material wall = lambert(glm::vec3(0.5f));
    wall.double_sided = false;
    // Between the sun and the plane. Facing down, also between the camera and the plane.
    const float turn = faces_up ? 0 : glm::radians(180.0f);
    builder.mesh_node("lid", builder.quad(builder.material(wall), 5),
                      at({0, 1, 0}) * glm::rotate(glm::mat4(1), turn, glm::vec3(1, 0, 0)));
    builder.mesh_node("plane", builder.quad(builder.material(lambert(glm::vec3(0.5f))), 10), glm::mat4(1));
    scene::Light bulb;
    bulb.intensity = 10;
    builder.light_node(bulb, at({0, 0.5f, 0}));
    builder.light_node(sun(glm::vec3(1), 4), shining_towards({0, -1, 0.1f}));
    builder.camera_node("camera", {0, faces_up ? 0.9f : 3, 0.01f}, {0, 0, 0}, 0.01f);
    expect_equal(estimate(linear_image(builder.build(), {16, 16}, path_settings(16, 0))), 0.5 * 40 / kPi,
                 faces_up ? "below the back of a lid" : "through the back of a lid");
  }
}

TEST_F(Paths, SeedAloneDeterminesBytes) {
  const scene::Scene scene = glossy_ball(true);
  const VkExtent2D extent{24, 16};
  const auto image = [&](uint32_t seed, uint32_t pixels, uint32_t segments,
                         settings::RayBackEnd back_end = settings::RayBackEnd::query) {
    settings::DrawSettings settings = path_settings(5, 3, seed);
    settings.environment_intensity = 1;
    settings.path->back_end = back_end;
    settings.path->pixels_per_dispatch = pixels;
    settings.path->segments_per_dispatch = segments;
    RenderBench bench(scene, extent, settings);
    const state::PoseState poses(scene);
    passes::ImageOutputs outputs;
    outputs.add(wire::kColorLinearF16);
    outputs.add(wire::kColorSrgb8);
    Taken taken = bench.take(poses, first_camera_view(scene, poses, extent), outputs);
    taken.planes.insert(taken.planes.end(), taken.image.rgba8.begin(), taken.image.rgba8.end());
    return taken.planes;
  };
  const std::vector<uint8_t> whole = image(7, 0, 0);
  EXPECT_EQ(whole, image(7, 0, 0));
  EXPECT_EQ(whole, image(7, 37, 1));
  EXPECT_EQ(whole, image(7, 100, 2));
  EXPECT_EQ(whole, image(7, 384, 5));
  EXPECT_NE(whole, image(8, 0, 0));
  ASSERT_TRUE(device().report().ray_tracing_pipeline);
  EXPECT_EQ(whole, image(7, 0, 0, settings::RayBackEnd::pipeline));
  EXPECT_EQ(whole, image(7, 100, 2, settings::RayBackEnd::pipeline));
}

// Depth, labels and normals beside path-traced colours are those of the raster.
TEST_F(Paths, PlanesAreThoseOfTheRaster) {
  const scene::Scene scene = glossy_ball(false);
  const state::PoseState poses(scene);
  const VkExtent2D extent{32, 32};
  passes::ImageOutputs outputs;
  outputs.add(wire::kDepthF32);
  outputs.add(wire::kInstanceU32);
  outputs.add(wire::kNormal);
  outputs.add(wire::kColorSrgb8);
  settings::DrawSettings settings = path_settings(1, 0);
  RenderBench traced(scene, extent, settings);
  settings.path.reset();
  RenderBench drawn(scene, extent, settings);
  const passes::View view = first_camera_view(scene, poses, extent);
  EXPECT_EQ(traced.take(poses, view, outputs).planes, drawn.take(poses, view, outputs).planes);
}

}  // namespace
}  // namespace fire3dv::test
