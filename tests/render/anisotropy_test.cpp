// Render tests of KHR_materials_anisotropy: lamps against an evaluation of the BRDF in double precision, for
// the raster and for paths; reciprocity, white furnace, direction, and the environment.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "renderer/scene/textures/environment.h"
#include "tests/render/support/material_tiles.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr double kPi = 3.14159265358979;

// Metal with anisotropic GGX facets. Directions are in the frame of tangent, bitangent, normal.
class AnisotropicMetal {
 public:
  AnisotropicMetal(double roughness, double strength)
      : alpha_b_(roughness * roughness), alpha_t_(glm::mix(alpha_b_, 1.0, strength * strength)) {
    constexpr int kSteps = 24;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double cosine = (i + 0.5) / kSteps, sine = std::sqrt(1 - cosine * cosine);
        const double angle = kPi / 2 * (j + 0.5) / kSteps;
        mean_loss_ +=
            2 * cosine / (kSteps * kSteps) * loss({sine * std::cos(angle), sine * std::sin(angle), cosine});
      }
    }
  }

  struct Brdf {
    double once, multiple;  // one bounce, all further bounces
  };
  Brdf brdf(const glm::dvec3& eye, const glm::dvec3& light, double f0) const {
    const glm::dvec3 h = glm::normalize(eye + light);
    const double fresnel = f0 + (1 - f0) * std::pow(1 - glm::dot(eye, h), 5);
    // Slope distribution of Heitz 2014, and the height-correlated masking of both directions.
    const double x = h.x / h.z / alpha_t_, y = h.y / h.z / alpha_b_;
    const double slopes = 1 / (kPi * alpha_t_ * alpha_b_ * std::pow(1 + x * x + y * y, 2));
    const double distribution = slopes / std::pow(h.z, 4);
    const double masking = 1 / (1 + lambda(eye) + lambda(light));
    const double mean = f0 + (1 - f0) / 21;
    const double multiple = mean * mean * (1 - mean_loss_) / (1 - mean * mean_loss_);
    return {fresnel * distribution * masking / (4 * eye.z * light.z),
            multiple * loss(eye) * loss(light) / (kPi * mean_loss_)};
  }

 private:
  double slope2(const glm::dvec3& v) const {
    return (alpha_t_ * alpha_t_ * v.x * v.x + alpha_b_ * alpha_b_ * v.y * v.y) / (v.z * v.z);
  }
  double lambda(const glm::dvec3& v) const { return (std::sqrt(1 + slope2(v)) - 1) / 2; }
  // 1 - albedo of white facets, by quadrature over facets that are seen (Dupuy and Benyoub 2023). The
  // renderer has a fit: docs/design/materials.md.
  double loss(const glm::dvec3& v) const {
    const auto scaled = [&](const glm::dvec3& d) { return glm::dvec3(alpha_t_ * d.x, alpha_b_ * d.y, d.z); };
    const glm::dvec3 stretched = glm::normalize(scaled(v));
    const auto length = [&](const glm::dvec3& d) { return glm::length(scaled(d)); };
    constexpr int kSteps = 32;
    double albedo = 0;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double angle = 2 * kPi * (i + 0.5) / kSteps;
        const double z = (1 - (j + 0.5) / kSteps) * (1 + stretched.z) - stretched.z, r = std::sqrt(1 - z * z);
        const glm::dvec3 cap = glm::dvec3(r * std::cos(angle), r * std::sin(angle), z) + stretched;
        const glm::dvec3 h = glm::normalize(scaled(cap));
        const glm::dvec3 light = 2 * glm::dot(h, v) * h - v;
        if (light.z <= 0) continue;
        albedo +=
            light.z * (v.z + length(v)) / (light.z * length(v) + v.z * length(light)) / (kSteps * kSteps);
      }
    }
    return 1 - albedo;
  }

  double alpha_b_, alpha_t_, mean_loss_ = 0;
};

scene::Material metal(float f0, float roughness, float strength, float rotation_rad = 0) {
  scene::Material material = matte(glm::vec3(f0));
  material.metallic = 1;
  material.roughness = roughness;
  material.anisotropy = strength;
  material.anisotropy_rotation_rad = rotation_rad;
  return material;
}

class Anisotropy : public ValidationIsSilent {};

TEST_F(Anisotropy, LampHighlightsMatchBrdf) {
  struct Case {
    float f0, roughness, strength, rotation_rad;
  };
  const Case cases[] = {
      {0.9f, 0.3f, 0.5f, 0}, {0.9f, 0.3f, 1, 0.7f}, {0.5f, 0.5f, 0.7f, 2}, {0.2f, 0.2f, 0.8f, -1}};
  std::vector<Tile> tiles;
  for (const Case& c : cases)
    tiles.push_back(
        {"strength " + std::to_string(c.strength), metal(c.f0, c.roughness, c.strength, c.rotation_rad)});
  const struct {
    glm::dvec3 eye, light;
  } pairs[] = {{towards(20, 90), towards(35, 250)},
               {towards(60, 0), towards(50, 170)},
               {towards(75, 200), towards(10, 30)},
               {towards(5, 0), towards(40, 90)}};
  double largest = 0;
  for (const auto& pair : pairs) {
    const std::vector<glm::dvec3> raster = lit_tiles({}, tiles, pair.eye, pair.light, false);
    const std::vector<glm::dvec3> traced = lit_tiles({}, tiles, pair.eye, pair.light, true);
    const std::vector<glm::dvec3> swapped = lit_tiles({}, tiles, pair.light, pair.eye, false);
    for (size_t i = 0; i < tiles.size(); ++i) {
      const double c = std::cos(cases[i].rotation_rad), s = std::sin(cases[i].rotation_rad);
      const auto local = [&](const glm::dvec3& d) {
        return glm::dvec3(c * d.x + s * d.z, c * d.z - s * d.x, d.y);
      };
      const auto [once, multiple] = AnisotropicMetal(cases[i].roughness, cases[i].strength)
                                        .brdf(local(pair.eye), local(pair.light), cases[i].f0);
      const double truth = once + multiple;
      const std::string what = tiles[i].name + ", eye " + std::to_string(pair.eye.x);
      const double found = raster[i].g;
      EXPECT_GT(truth, 1e-3) << what;
      EXPECT_NEAR(found, truth, 0.015 * once + 0.15 * multiple) << what;  // the losses are fitted
      EXPECT_NEAR(traced[i].g / found, 1, 0.005) << what;
      EXPECT_NEAR(swapped[i].g / found, 1, 0.005) << what << ", swapped";
      largest = std::max(largest, std::abs(found / truth - 1));
    }
  }
  RecordProperty("largest difference from the BRDF", std::to_string(largest));
}

// A quarter turn, by the factor or by the texture's direction, turns the highlight.
TEST_F(Anisotropy, ARotationTurnsTheHighlight) {
  SceneBuilder builder;
  const auto texture = [&](glm::vec3 texel) {
    return builder.texture(2, 2, false, [=](float, float) { return glm::vec4(texel, 1); });
  };
  const float quarter = static_cast<float>(kPi / 2);
  std::vector<Tile> tiles{
      {"along X", metal(0.8f, 0.2f, 0.7f)},           {"along Z", metal(0.8f, 0.2f, 0.7f, quarter)},
      {"along Z by texture", metal(0.8f, 0.2f, 1)},   {"along X by both", metal(0.8f, 0.2f, 1, -quarter)},
      {"isotropic by texture", metal(0.8f, 0.2f, 1)}, {"isotropic", metal(0.8f, 0.2f, 0)}};
  tiles[2].material.anisotropy_texture.texture = tiles[3].material.anisotropy_texture.texture =
      texture({0.5f, 1, 0.7f});
  tiles[4].material.anisotropy_texture.texture = texture({1, 0.5f, 0});
  const auto seen = [&](const glm::dvec3& to_light) {
    std::vector<double> result;
    for (const glm::dvec3& radiance : lit_tiles(builder, tiles, {0, 1, 0}, to_light, false))
      result.push_back(radiance.g);
    return result;
  };
  const std::vector<double> beside_x = seen(towards(40, 0)), beside_z = seen(towards(40, 90));
  EXPECT_GT(beside_x[0], 3 * beside_z[0]);
  for (const size_t turned : {1u, 2u}) {
    EXPECT_NEAR(beside_z[turned] / beside_x[0], 1, 0.02) << turned;  // 8-bit strength
    EXPECT_NEAR(beside_x[turned] / beside_z[0], 1, 0.02) << turned;
  }
  EXPECT_NEAR(beside_x[3] / beside_x[0], 1, 0.02);
  EXPECT_NEAR(beside_x[4] / beside_x[5], 1, 0.002);
  EXPECT_NEAR(beside_z[5] / beside_x[5], 1, 0.002);
}

// Bounds: docs/design/materials.md.
TEST_F(Anisotropy, WhiteMetalReflectsWhiteFurnace) {
  std::vector<Tile> tiles;
  for (const float roughness : {0.1f, 0.3f, 0.6f}) {
    for (const float strength : {0.4f, 0.7f, 1.0f})
      tiles.push_back({"roughness " + std::to_string(roughness) + ", strength " + std::to_string(strength),
                       metal(1, roughness, strength)});
  }
  double least = 2, most = 0;
  for (const double turn : {0.0, 90.0}) {
    for (const double degrees : {15.0, 70.0}) {
      const auto pixels = tile_pixels({}, tiles, towards(degrees, turn), furnace_settings(64));
      for (size_t i = 0; i < tiles.size(); ++i) {
        const MeanRadiance seen = mean_radiance(pixels[i]);
        const double mean = seen.mean.g, error = seen.error.g;
        const std::string what =
            tiles[i].name + ", " + std::to_string(degrees) + " degrees, turned by " + std::to_string(turn);
        RecordProperty(what, std::to_string(mean) + " +- " + std::to_string(error));
        EXPECT_GE(mean, 0.98 - 4 * error) << what;
        EXPECT_LE(mean, 1.02 + 4 * error) << what;
        EXPECT_LT(error, 0.01) << what;
        least = std::min(least, mean);
        most = std::max(most, mean);
      }
    }
  }
  RecordProperty("smallest", std::to_string(least));
  RecordProperty("largest", std::to_string(most));
}

// A disc that is brushed around its centre, as lids of pans are: the tangents are radial.
uint32_t brushed_disc(SceneBuilder& builder, uint32_t material) {
  constexpr uint32_t kSegments = 96;
  std::vector<glm::vec3> positions;
  std::vector<scene::VertexAttributes> attributes;
  std::vector<uint32_t> indices;
  for (uint32_t s = 0; s <= kSegments; ++s) {
    const auto angle = static_cast<float>(2 * kPi * s / kSegments);
    const glm::vec3 radial(std::cos(angle), 0, std::sin(angle));
    for (const float radius : {0.05f, 0.95f}) {
      positions.push_back(radius * radial);
      attributes.push_back({.tangent = glm::vec4(radial, 1), .normal = {0, 1, 0}});
    }
    const uint32_t a = 2 * s;
    if (s < kSegments) indices.insert(indices.end(), {a, a + 2, a + 1, a + 1, a + 2, a + 3});
  }
  return builder.mesh(material, positions, attributes, indices);
}

TEST_F(Anisotropy, BrushedMetalInTheStudio) {
  SceneBuilder builder;
  const glm::mat4 tilted = glm::rotate(glm::mat4(1), 1.1f, glm::vec3(1, 0, 0));
  scene::Material steel = metal(0.85f, 0.25f, 0.8f);
  steel.double_sided = true;
  builder.mesh_node("disc", brushed_disc(builder, builder.material(steel)), at({-1.1f, 0, 0}) * tilted);
  builder.mesh_node("ball", builder.sphere(builder.material(metal(0.8f, 0.2f, 0.7f)), 0.9f),
                    at({1.1f, 0, 0}));
  builder.light_node(sun({1, 0.97f, 0.92f}, 2), shining_towards({-0.3f, -0.5f, -1}));
  builder.camera_node("camera", {0, 0, 5.5f}, {0, 0, 0}, 0.4f);
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings;
  settings.background.show_environment = true;
  settings.shadows.method = settings::ShadowMethod::off;
  settings.raster = settings::RasterPath::visibility;
  const sinks::FrameImage drawn = RenderBench(scene, {320, 160}, settings).draw_at_rest();
  EXPECT_TRUE(matches_golden(drawn, "brushed_metal", Tolerance::colour()));
  settings.raster = settings::RasterPath::forward;
  EXPECT_TRUE(matches_image(RenderBench(scene, {320, 160}, settings).draw_at_rest(), drawn,
                            "brushed_metal_forward", Tolerance::colour()));
}

// The raster's look-ups along the tangent are an approximation, which the mean of the image keeps.
TEST_F(Anisotropy, EnvironmentLightMatchesPaths) {
  for (const float roughness : {0.15f, 0.4f}) {
    SceneBuilder builder;
    builder.mesh_node("ball", builder.sphere(builder.material(metal(0.8f, roughness, 0.7f)), 1, 64),
                      glm::mat4(1));
    builder.camera_node("camera", {0, 1, 3}, {0, 0, 0});
    const scene::Scene scene = builder.build();
    const state::PoseState poses(scene);
    double means[2] = {0, 0};
    for (const bool paths : {false, true}) {
      settings::DrawSettings settings = dark_settings(paths);
      if (paths) settings.path->samples_per_pixel = 64;
      settings.environment_intensity = 1;
      const VkExtent2D extent{32, 32};
      RenderBench bench(scene, extent, settings);
      passes::ImageOutputs outputs;
      outputs.add(wire::kColorLinearF16);
      for (const uint64_t pixel : bench.take(poses, first_camera_view(scene, poses, extent), outputs)
                                      .plane<uint64_t>(wire::kColorLinearF16))
        means[paths] += glm::unpackHalf4x16(pixel).g;
    }
    RecordProperty("roughness " + std::to_string(roughness), std::to_string(means[1] / means[0]));
    EXPECT_NEAR(means[1] / means[0], 1, 0.05) << roughness;
  }
}

}  // namespace
}  // namespace fire3dv::test
