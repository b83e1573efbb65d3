// Render tests of volumes in path-traced images, against closed forms: Fresnel's equations, Snell's law, the
// Beer-Lambert law and the white furnace.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "renderer/scene/textures/environment.h"
#include "tests/render/support/path_bench.h"

namespace fire3dv::test {
namespace {

class Glass : public ValidationIsSilent {};

scene::Material glass(float ior = 1.5f, float roughness = 0) {
  scene::Material material = matte(glm::vec3(1));
  material.roughness = roughness;
  material.transmission = 1;
  material.thickness = 1;
  material.ior = ior;
  return material;
}

settings::DrawSettings in_environment(uint32_t samples, uint32_t bounces,
                                      const std::function<glm::vec3(const glm::vec3&)>& radiance) {
  settings::DrawSettings settings = path_settings(samples, bounces);
  settings.environment =
      std::make_shared<scene::EnvironmentImage>(scene::make_environment(256, 128, radiance));
  settings.environment_intensity = 1;
  return settings;
}

glm::vec3 white(const glm::vec3&) {
  return glm::vec3(1);
}
glm::vec3 ground(const glm::vec3& direction) {
  return glm::vec3(direction.y < 0 ? 1.0f : 0.0f);
}
glm::vec3 sky(const glm::vec3& direction) {
  return glm::vec3(direction.y < 0 ? 0.0f : 1.0f);
}

// One direction for the whole image: a narrow view of the origin from far away.
void look_at_origin(SceneBuilder& builder, glm::vec3 from, float half_width = 0.3f) {
  from.z += 1e-3f;  // never along the camera's vertical
  constexpr float kDistance = 300;
  builder.camera_node("camera", kDistance * glm::normalize(from), {0, 0, 0},
                      2 * std::atan(half_width / kDistance));
}

constexpr VkExtent2D kExtent{16, 16};

// Unpolarised reflectance from air, by the cosines of incidence and refraction.
double fresnel(double sine, double n) {
  const double i = std::sqrt(1 - sine * sine), t = std::sqrt(1 - sine * sine / (n * n));
  const double s = (i - n * t) / (i + n * t), p = (n * i - t) / (n * i + t);
  return (s * s + p * p) / 2;
}

TEST_F(Glass, AWhiteFurnaceHidesABall) {
  for (const float roughness : {0.0f, 0.4f}) {
    SceneBuilder builder;
    builder.mesh_node("ball", builder.sphere(builder.material(glass(1.5f, roughness)), 1, 128), glm::mat4(1));
    look_at_origin(builder, {0, 0, 1}, 0.69f);  // the image lies within the ball
    const Estimate seen =
        estimate(linear_image(builder.build(), kExtent, in_environment(roughness > 0 ? 64 : 4, 64, white)));
    expect_equal(seen, 1, "roughness " + std::to_string(roughness));
  }
}

// Layers and partial transparency keep the energy, too.
TEST_F(Glass, WhiteFurnaceHidesGlassLayers) {
  for (const auto& [name, coat, share, metallic] : {std::tuple("half transparent", 0.0f, 0.5f, 0.0f),
                                                    {"coated", 1.0f, 1.0f, 0.0f},
                                                    {"half a metal", 0.0f, 0.7f, 0.5f},
                                                    {"all of it", 1.0f, 0.5f, 0.3f}}) {
    scene::Material material = glass(1.5f, 0.3f);
    material.transmission = share;
    material.metallic = metallic;
    material.clearcoat = coat;
    material.clearcoat_roughness = 0.2f;
    SceneBuilder builder;
    builder.mesh_node("slab", builder.box(builder.material(material), {100, 1, 100}), glm::mat4(1));
    look_at_origin(builder, {0, 1, 0.5f});
    const Estimate seen = estimate(linear_image(builder.build(), kExtent, in_environment(64, 64, white)));
    RecordProperty(name, std::to_string(seen.mean) + " +- " + std::to_string(seen.error));
    // The model of clearcoat loses up to 2 %.
    EXPECT_GT(seen.mean, 0.98 - 4 * seen.error) << name;
    EXPECT_LT(seen.mean, 1.005 + 4 * seen.error) << name;
    EXPECT_LT(seen.error, 0.005) << name;
  }
}

// Light that a slab lets pass and reflects, with all reflections between its faces.
TEST_F(Glass, SlabFollowsFresnelAndBeerLambert) {
  const glm::dvec3 color(0.9, 0.5, 0.2);
  const double distance = 1.3, thickness = 2;
  for (const double ior : {1.0, 1.7}) {
    for (const double degrees : {0.0, 60.0}) {
      scene::Material material = glass(static_cast<float>(ior));
      material.attenuation_color = color;
      material.attenuation_distance_m = static_cast<float>(distance);
      SceneBuilder builder;
      builder.mesh_node("slab", builder.box(builder.material(material), {100, thickness / 2, 100}),
                        glm::mat4(1));
      const double sine = std::sin(glm::radians(degrees));
      look_at_origin(builder, {static_cast<float>(sine), std::sqrt(1 - static_cast<float>(sine * sine)), 0});
      const scene::Scene scene = builder.build();
      const auto passed = linear_image(scene, kExtent, in_environment(32, 64, ground));
      const auto reflected = linear_image(scene, kExtent, in_environment(32, 64, sky));
      const double f = fresnel(sine, ior), length = thickness / std::sqrt(1 - sine * sine / (ior * ior));
      for (int c = 0; c < 3; ++c) {
        const double kept = std::pow(color[c], length / distance);
        const double all = 1 - f * f * kept * kept;
        const std::string what = "ior " + std::to_string(ior) + ", " + std::to_string(degrees) +
                                 " degrees, channel " + std::to_string(c);
        expect_equal(estimate(passed, c), (1 - f) * (1 - f) * kept / all, "passed, " + what, 0.005);
        const double back = f + (1 - f) * (1 - f) * f * kept * kept / all;
        const Estimate seen = estimate(reflected, c);
        EXPECT_NEAR(seen.mean, back, 4 * seen.error + 0.005 * back + 1e-4) << "reflected, " << what;
      }
    }
  }
}

// Environment samples (MIS) count once: a rough slab passes what it does not reflect.
TEST_F(Glass, RoughSlabConservesEnergy) {
  SceneBuilder builder;
  builder.mesh_node("slab", builder.box(builder.material(glass(1.5f, 0.5f)), {100, 1, 100}), glm::mat4(1));
  look_at_origin(builder, {1, 1, 0});
  const scene::Scene scene = builder.build();
  const Estimate passed = estimate(linear_image(scene, kExtent, in_environment(128, 64, ground)));
  const Estimate reflected = estimate(linear_image(scene, kExtent, in_environment(128, 64, sky)));
  RecordProperty("passed", std::to_string(passed.mean));
  EXPECT_GT(passed.mean, 0.5);
  EXPECT_NEAR(passed.mean + reflected.mean, 1, 4 * std::hypot(passed.error, reflected.error) + 0.005);
}

// Prism with a horizontal top; its lower face is turned by `angle` about Z.
uint32_t prism(SceneBuilder& builder, const scene::Material& material, double angle) {
  const auto low = static_cast<float>(-4 * std::tan(angle));
  const std::vector<glm::vec3> corners{{-2, 2, -9}, {2, 2, -9}, {2, 2 + low, -9},
                                       {-2, 2, 9},  {2, 2, 9},  {2, 2 + low, 9}};
  return builder.triangles(builder.material(material), corners,
                           {0, 1, 2, 3, 5, 4, 0, 3, 4, 0, 4, 1, 1, 4, 5, 1, 5, 2, 0, 2, 5, 0, 5, 3});
}

// Radiance that grows towards +X, so that it tells angles.
glm::vec3 slope(const glm::vec3& direction) {
  return glm::vec3(0.6f + 0.5f * direction.x);
}

glm::vec3 fall(const glm::vec3& direction) {
  return glm::vec3(0.6f - 0.5f * direction.x);
}

// Light enters the prism along the normal and leaves through the lower face.
double seen_through_prism(double angle, double n, double gradient = 0.5) {
  const double turned = std::asin(n * std::sin(angle)) - angle;
  const double f1 = fresnel(0, n), f2 = fresnel(n * std::sin(angle), n);
  return f1 * 0.6 + (1 - f1) * (1 - f2) * (0.6 + gradient * std::sin(turned));
}

TEST_F(Glass, PrismTurnsLightBySnellsLaw) {
  const double angle = glm::radians(30.0);
  for (const double ior : {1.2, 1.5, 1.8}) {
    SceneBuilder builder;
    builder.mesh_node("prism", prism(builder, glass(static_cast<float>(ior)), angle), glm::mat4(1));
    look_at_origin(builder, {0, 1, 0});
    // One bounce: without reflections inside.
    const Estimate seen = estimate(linear_image(builder.build(), kExtent, in_environment(256, 1, slope)));
    expect_equal(seen, seen_through_prism(angle, ior), "ior " + std::to_string(ior));
    EXPECT_GT(std::abs(seen_through_prism(angle, ior + 0.03) - seen_through_prism(angle, ior)),
              0.005 * seen.mean);
  }
}

// Each colour has the index of Cauchy's formula in KHR_materials_dispersion, at 656.3, 587.6 and 486.1 nm.
TEST_F(Glass, APrismDispersesByCauchysFormula) {
  const double angle = glm::radians(20.0), ior = 1.5, abbe = 2.5;
  scene::Material material = glass(static_cast<float>(ior));
  material.dispersion = static_cast<float>(20 / abbe);
  SceneBuilder builder;
  builder.mesh_node("prism", prism(builder, material, angle), glm::mat4(1));
  look_at_origin(builder, {0, 1, 0});
  const scene::Scene scene = builder.build();
  const auto pixels = linear_image(scene, {32, 32}, in_environment(128, 1, fall));
  const double wavelengths_nm[] = {656.3, 587.6, 486.1};
  const auto dispersed = [&](int c) {
    return ior + (ior - 1) / abbe * (523655 / (wavelengths_nm[c] * wavelengths_nm[c]) - 1.5168);
  };
  for (int c = 0; c < 3; ++c)
    expect_equal(estimate(pixels, c), seen_through_prism(angle, dispersed(c), -0.5),
                 "channel " + std::to_string(c));
  EXPECT_LT(estimate(pixels, 2).mean, 0.95 * estimate(pixels, 0).mean);

  // The raster's rays also have the environment for what the far side reflects.
  settings::DrawSettings raster = in_environment(1, 1, fall);
  raster.path.reset();
  raster.ray_effects.on.refraction = true;
  const auto drawn = linear_image(scene, {32, 32}, raster);
  for (int c = 0; c < 3; ++c) {
    const double truth = seen_through_prism(angle, dispersed(c), -0.5), seen = estimate(drawn, c).mean;
    RecordProperty("raster, channel " + std::to_string(c),
                   std::to_string(seen) + " for " + std::to_string(truth));
    EXPECT_NEAR(seen, truth, 0.06 * truth) << c;
    EXPECT_NEAR(seen / estimate(drawn, 0).mean, truth / seen_through_prism(angle, dispersed(0), -0.5), 0.01)
        << c;
  }
}

TEST_F(Glass, WhiteFurnaceHidesDispersiveBall) {
  scene::Material material = glass();
  material.dispersion = 1;
  SceneBuilder builder;
  builder.mesh_node("ball", builder.sphere(builder.material(material), 1, 128), glm::mat4(1));
  look_at_origin(builder, {0, 0, 1}, 0.69f);
  const auto pixels = linear_image(builder.build(), {32, 32}, in_environment(64, 32, white));
  for (int c = 0; c < 3; ++c) expect_equal(estimate(pixels, c), 1, "channel " + std::to_string(c), 0.002);
}

TEST_F(Glass, APrismReflectsTotally) {
  const double angle = glm::radians(45.0);  // beyond the critical angle
  SceneBuilder builder;
  builder.mesh_node("prism", prism(builder, glass(), angle), glm::mat4(1));
  look_at_origin(builder, {0, 1, 0});
  const Estimate seen = estimate(linear_image(builder.build(), kExtent, in_environment(256, 2, slope)));
  // Leaves towards +X through the vertical face.
  expect_equal(seen, 0.04 * 0.6 + 0.96 * 0.96 * 1.1, "total reflection");
}

// Radiance is proportional to the square of the index.
TEST_F(Glass, EnclosedLampScalesByIndexSquared) {
  SceneBuilder builder;
  scene::Material lamp = lambert(glm::vec3(0));
  lamp.emissive = glm::vec3(1);
  builder.mesh_node("lamp", builder.quad(builder.material(lamp), 90), glm::mat4(1));
  builder.mesh_node("slab", builder.box(builder.material(glass()), {100, 1, 100}), glm::mat4(1));
  look_at_origin(builder, {0, 1, 0.001f});
  expect_equal(estimate(linear_image(builder.build(), kExtent, path_settings(256, 64))), 0.96 / 2.25, "lamp");
}

// Volumes in volumes: each replaces the one around it. Hollow ones are left and entered again.
TEST_F(Glass, LengthInsideIsOfEachVolume) {
  scene::Material outer = glass(1);
  outer.attenuation_color = glm::vec3(0.5f, 0.6f, 0.7f);
  outer.attenuation_distance_m = 1;
  scene::Material inner = glass(1);
  inner.attenuation_color = glm::vec3(0.8f);
  inner.attenuation_distance_m = 1;
  for (const bool hollow : {false, true}) {
    SceneBuilder builder;
    const uint32_t around = builder.material(outer);
    builder.mesh_node("outer", builder.box(around, {50, 1.5f, 50}), glm::mat4(1));
    // A mirrored box faces inwards once its normals do.
    const std::vector<glm::vec3> corners{{-40, -0.5f, -40}, {40, -0.5f, -40}, {40, -0.5f, 40},
                                         {-40, -0.5f, 40},  {-40, 0.5f, -40}, {40, 0.5f, -40},
                                         {40, 0.5f, 40},    {-40, 0.5f, 40}};
    if (hollow) {
      builder.mesh_node("bubble", builder.triangles(around, corners, {4, 5, 6, 4, 6, 7, 0, 2, 1, 0, 3, 2}),
                        glm::mat4(1));
    } else {
      builder.mesh_node("inner", builder.box(builder.material(inner), {40, 0.5f, 40}), glm::mat4(1));
    }
    look_at_origin(builder, {0, 1, 0.001f});
    const auto pixels = linear_image(builder.build(), kExtent, in_environment(4, 16, white));
    for (int c = 0; c < 3; ++c) {
      const double truth = std::pow(outer.attenuation_color[c], 2) * (hollow ? 1 : 0.8);
      expect_equal(estimate(pixels, c), truth, hollow ? "hollow" : "nested");
    }
  }
}

// A camera inside of a volume: the first ray is absorbed, and leaves through the back of the surface.
TEST_F(Glass, ACameraInsideSeesAbsorbedLight) {
  scene::Material material = glass(1);
  material.attenuation_color = glm::vec3(0.5f);
  material.attenuation_distance_m = 2;
  SceneBuilder builder;
  builder.mesh_node("ball", builder.sphere(builder.material(material), 3, 128), glm::mat4(1));
  builder.camera_node("camera", {0, 0, 0}, {0, 0, -1}, 0.3f);
  expect_equal(estimate(linear_image(builder.build(), kExtent, in_environment(4, 4, white))),
               std::pow(0.5, 1.5), "camera in a ball");
}

// Lamps do not shine through volumes; the environment does, by sampled directions.
TEST_F(Glass, VolumeBlocksLampsAndPassesEnvironment) {
  SceneBuilder builder;
  builder.mesh_node("slab", builder.box(builder.material(glass(1)), {500, 0.1f, 500}), at({0, 1, 0}));
  builder.mesh_node("plane", builder.quad(builder.material(lambert(glm::vec3(0.5f))), 400), glm::mat4(1));
  builder.light_node(sun(glm::vec3(1), 4), shining_towards({0, -1, 0.1f}));
  builder.camera_node("camera", {0, 0.8f, 0.1f}, {0, 0, 0}, 0.5f);
  const scene::Scene scene = builder.build();
  EXPECT_EQ(estimate(linear_image(scene, kExtent, path_settings(16, 8))).mean, 0);
  expect_equal(estimate(linear_image(scene, kExtent, in_environment(64, 8, white))), 0.5, "environment");
}

// A leaf lit from above: seen from below it shows the share that passes, from above the rest.
TEST_F(Glass, ALeafPassesDiffuseLight) {
  scene::Material leaf = lambert({0.8f, 0.6f, 0.4f});
  leaf.diffuse_transmission = 0.25f;
  leaf.diffuse_transmission_color = {0.2f, 0.9f, 0.5f};
  for (const bool from_below : {false, true}) {
    SceneBuilder builder;
    builder.mesh_node("leaf", builder.quad(builder.material(leaf), 50), glm::mat4(1));
    builder.light_node(sun(glm::vec3(1), 4), shining_towards({0, -1, 0.1f}));
    look_at_origin(builder, {0, from_below ? -1.0f : 1.0f, 0.3f});
    const auto pixels = linear_image(builder.build(), kExtent, path_settings(4, 0));
    for (int c = 0; c < 3; ++c) {
      const double albedo =
          from_below ? 0.25 * leaf.diffuse_transmission_color[c] : 0.75 * leaf.base_color[c];
      expect_equal(estimate(pixels, c), albedo * 4 / std::sqrt(1.01) / kPi, from_below ? "below" : "above");
    }
  }
}

// The same in the raster, by all shadow techniques; light from behind does not enter a closed body.
TEST_F(Glass, LeafPassesDiffuseLightInRaster) {
  scene::Material leaf = lambert({0.8f, 0.6f, 0.4f});
  leaf.diffuse_transmission = 0.25f;
  leaf.diffuse_transmission_color = {0.2f, 0.9f, 0.5f};
  using settings::ShadowMethod;
  const struct {
    const char* name;
    ShadowMethod method;
    bool hybrid;
  } techniques[] = {{"rays", ShadowMethod::ray, false},
                    {"maps and rays", ShadowMethod::ray, true},
                    {"maps", ShadowMethod::map, true},
                    {"none", ShadowMethod::off, true}};
  for (const bool is_closed : {false, true}) {
    SceneBuilder builder;
    const uint32_t material = builder.material(leaf);
    builder.mesh_node("leaf", is_closed ? builder.box(material, {5, 0.5f, 5}) : builder.quad(material, 5),
                      glm::mat4(1));
    builder.light_node(sun(glm::vec3(1), 4), shining_towards({0, -1, 0.1f}));
    look_at_origin(builder, {0, -1, 0.3f});
    const scene::Scene scene = builder.build();
    for (const auto& technique : techniques) {
      if (is_closed && technique.method == ShadowMethod::off) continue;
      settings::DrawSettings settings = path_settings(1, 0);
      settings.path.reset();
      settings.shadows.method = technique.method;
      settings.shadows.hybrid = technique.hybrid;
      const auto pixels = linear_image(scene, kExtent, settings);
      for (int c = 0; c < 3; ++c) {
        const double albedo = is_closed ? 0 : 0.25 * leaf.diffuse_transmission_color[c];
        EXPECT_NEAR(estimate(pixels, c).mean, albedo * 4 / std::sqrt(1.01) / kPi, 1e-3)
            << technique.name << (is_closed ? ", closed" : "");
      }
    }
  }
}

// Light of the ground alone, seen from above, and of the sky alone.
TEST_F(Glass, LeafPassesEnvironmentInRaster) {
  scene::Material leaf = lambert({0.8f, 0.6f, 0.4f});
  leaf.diffuse_transmission = 0.25f;
  leaf.diffuse_transmission_color = {0.2f, 0.9f, 0.5f};
  SceneBuilder builder;
  builder.mesh_node("leaf", builder.quad(builder.material(leaf), 5), glm::mat4(1));
  look_at_origin(builder, {0, 1, 0.3f});
  const scene::Scene scene = builder.build();
  for (const bool from_below : {false, true}) {
    settings::DrawSettings settings = in_environment(1, 0, from_below ? ground : sky);
    settings.path.reset();
    const auto pixels = linear_image(scene, kExtent, settings);
    for (int c = 0; c < 3; ++c) {
      const double truth = from_below ? 0.25 * leaf.diffuse_transmission_color[c] : 0.75 * leaf.base_color[c];
      EXPECT_NEAR(estimate(pixels, c).mean, truth, 0.02 * truth + 0.002) << from_below << ", channel " << c;
    }
  }
}

// Shares of textures; energy of all lobes together.
TEST_F(Glass, AWhiteFurnaceHidesALeaf) {
  for (const float roughness : {0.2f, 1.0f}) {
    for (const float thickness : {0.0f, 1.0f}) {
      scene::Material leaf = matte(glm::vec3(1));
      leaf.double_sided = true;
      leaf.roughness = roughness;
      leaf.thickness = thickness;
      leaf.diffuse_transmission = 1;
      SceneBuilder builder;
      leaf.diffuse_transmission_texture.texture =
          builder.texture(1, 1, false, [](float, float) { return glm::vec4(0, 0, 0, 0.6f); });
      builder.mesh_node("leaf", builder.box(builder.material(leaf), {50, 0.01f, 50}), glm::mat4(1));
      look_at_origin(builder, {0, 1, 0.7f});
      const scene::Scene scene = builder.build();
      settings::DrawSettings settings = in_environment(64, 64, white);
      expect_equal(estimate(linear_image(scene, kExtent, settings)), 1,
                   "roughness " + std::to_string(roughness));
      settings.path.reset();
      EXPECT_NEAR(estimate(linear_image(scene, kExtent, settings)).mean, 1, 0.002) << "raster";
    }
  }
}

// Clear and rough balls on a chequered floor.
scene::Scene glass_over_floor() {
  SceneBuilder builder;
  scene::Material clear = glass(1.5f, 0.0f);
  clear.attenuation_color = {0.6f, 0.9f, 0.7f};
  clear.attenuation_distance_m = 1;
  clear.dispersion = 1;
  builder.mesh_node("clear", builder.sphere(builder.material(clear), 0.5f), at({-0.55f, 0.5f, 0}));
  builder.mesh_node("rough", builder.sphere(builder.material(glass(1.4f, 0.3f)), 0.5f), at({0.55f, 0.5f, 0}));
  scene::Material board = matte(glm::vec3(1));
  board.base_color_texture.texture = builder.texture(16, 16, true, [](float u, float v) {
    const bool dark = (static_cast<int>(u * 16) + static_cast<int>(v * 16)) % 2 == 1;
    return glm::vec4(glm::vec3(dark ? 0.1f : 0.9f), 1);
  });
  builder.mesh_node("floor", builder.quad(builder.material(board), 3), glm::mat4(1));
  scene::Light bulb;
  bulb.intensity = 20;
  builder.light_node(bulb, at({1.5f, 2.5f, 1}));
  builder.camera_node("camera", {0, 1.4f, 3}, {0, 0.4f, 0});
  return builder.build();
}

TEST_F(Glass, SeedAloneDeterminesBytes) {
  const scene::Scene scene = glass_over_floor();
  const auto image = [&](uint32_t pixels, uint32_t segments, settings::RayBackEnd back_end) {
    settings::DrawSettings settings = path_settings(5, 6, 7);
    settings.environment_intensity = 1;
    settings.path->back_end = back_end;
    settings.path->pixels_per_dispatch = pixels;
    settings.path->segments_per_dispatch = segments;
    return linear_image(scene, {24, 16}, settings);
  };
  const auto whole = image(0, 0, settings::RayBackEnd::query);
  EXPECT_EQ(whole, image(37, 1, settings::RayBackEnd::query));
  ASSERT_TRUE(device().report().ray_tracing_pipeline);
  EXPECT_EQ(whole, image(100, 2, settings::RayBackEnd::pipeline));
  for (const glm::dvec3& pixel : whole) EXPECT_TRUE(std::isfinite(pixel.r + pixel.g + pixel.b));
}

}  // namespace
}  // namespace fire3dv::test
