// Render tests of KHR_materials_iridescence: the reflectance of thin films against the formula in double
// precision and against exact optics at two thicknesses; raster against paths; films on glass; white
// furnace; the environment.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderer/scene/textures/environment.h"
#include "tests/render/support/material_tiles.h"
#include "tests/render/support/path_bench.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

double schlick(double f0, double cosine) {
  return f0 + (1 - f0) * std::pow(1 - cosine, 5);
}

// The text of KHR_materials_iridescence, "Iridescence Fresnel".
glm::dvec3 film_reflectance(double ior, double thickness_nm, double base_f0, double cosine) {
  const double inside = std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
  const double r12 = schlick(std::pow((ior - 1) / (ior + 1), 2), cosine), t121 = 1 - r12;
  const double root = std::sqrt(base_f0), base_ior = (1 + root) / (1 - root);
  const double r23 = schlick(std::pow((base_ior - ior) / (base_ior + ior), 2), inside);
  const double shift = kPi + (base_ior < ior ? kPi : 0);
  const double product = r12 * r23, once = t121 * t121 * r23 / (1 - product);
  const double gaussians[4][3] = {// amplitude, position, variance of x, y, z and the second maximum of x
                                  {5.4856e-13, 1.6810e6, 4.3278e9},
                                  {4.4201e-13, 1.7953e6, 9.3046e9},
                                  {5.2481e-13, 2.2084e6, 6.6121e9},
                                  {9.7470e-14, 2.2399e6, 4.5282e9}};
  glm::dvec3 rgb(r12 + once);
  for (int m = 1; m <= 2; ++m) {
    const double phase = 2 * kPi * m * 2 * ior * thickness_nm * inside * 1e-9;
    double response[4];
    for (int i = 0; i < 4; ++i) {
      const auto& [amplitude, position, variance] = gaussians[i];
      response[i] = amplitude / 1.0685e-7 * std::sqrt(2 * kPi * variance) *
                    std::cos(position * phase + m * shift) * std::exp(-phase * phase * variance);
    }
    const double x = response[0] + response[3], y = response[1], z = response[2];
    const glm::dvec3 color(3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                           -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                           0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
    rgb += (once - t121) * std::pow(product, m / 2.0) * 2.0 * color;
  }
  return glm::clamp(rgb, 0.0, 1.0);
}

scene::Material coated(float base, float metallic, float roughness, float ior, float thickness_nm) {
  scene::Material material = matte(glm::vec3(base));
  material.metallic = metallic;
  material.roughness = roughness;
  material.iridescence = 1;
  material.iridescence_ior = ior;
  material.iridescence_thickness_max_nm = thickness_nm;
  return material;
}

class Iridescence : public ValidationIsSilent {};

// At the mirror direction of a smooth surface the facets' term dominates. Its quotient by that of a white
// metal, whose reflectance is 1, is the reflectance of the film.
TEST_F(Iridescence, HighlightsMatchThinFilm) {
  struct Case {
    float f0, ior, thickness_nm;
  };
  const Case cases[] = {
      {0.5f, 1.3f, 400}, {0.5f, 1.8f, 250}, {0.9f, 1.5f, 600}, {0.1f, 2.2f, 150}, {0.2f, 1.4f, 1200}};
  std::vector<Tile> tiles;
  for (const Case& c : cases)
    tiles.push_back(
        {"thickness " + std::to_string(c.thickness_nm), coated(c.f0, 1, 0.1f, c.ior, c.thickness_nm)});
  scene::Material white = matte(glm::vec3(1));
  white.metallic = 1;
  white.roughness = 0.1f;
  tiles.push_back({"white", white});
  double largest = 0;
  for (const double degrees : {15.0, 60.0}) {
    const glm::dvec3 eye = towards(degrees, 0), light = towards(degrees, 180);
    const std::vector<glm::dvec3> raster = lit_tiles({}, tiles, eye, light, false);
    const std::vector<glm::dvec3> traced = lit_tiles({}, tiles, eye, light, true);
    for (size_t i = 0; i + 1 < tiles.size(); ++i) {
      const glm::dvec3 truth =
          film_reflectance(cases[i].ior, cases[i].thickness_nm, cases[i].f0, std::cos(glm::radians(degrees)));
      for (int c = 0; c < 3; ++c) {
        const std::string what =
            tiles[i].name + ", " + std::to_string(degrees) + " degrees, channel " + std::to_string(c);
        const double found = raster[i][c] / raster.back()[c];
        EXPECT_NEAR(found, truth[c], 0.003 + 0.005 * truth[c]) << what;
        EXPECT_NEAR(traced[i][c], raster[i][c], 0.005 * raster[i][c] + 1e-4) << what;
        largest = std::max(largest, std::abs(found - truth[c]));
      }
    }
  }
  RecordProperty("largest difference from the formula", std::to_string(largest));
}

// Exact optics: a film of the root of the base's index and a quarter of the wavelength inside reflects
// nothing of that wavelength; one of half the wavelength reflects as the bare base.
TEST_F(Iridescence, QuarterWaveFilmIsAntireflective) {
  const double base_ior = 2.25, ior = 1.5, quarter_nm = 550 / (4 * ior);
  const double f0 = std::pow((base_ior - 1) / (base_ior + 1), 2);
  std::vector<Tile> tiles;
  for (const double thickness_nm : {quarter_nm, 2 * quarter_nm})
    tiles.push_back({"film", coated(static_cast<float>(f0), 1, 0.1f, static_cast<float>(ior),
                                    static_cast<float>(thickness_nm))});
  tiles.push_back({"bare", tiles[0].material});
  tiles.back().material.iridescence = 0;
  const std::vector<glm::dvec3> seen = lit_tiles({}, tiles, towards(1, 0), towards(1, 180), false);
  EXPECT_LT(seen[0].g, 0.1 * seen[2].g);
  EXPECT_GT(seen[0].b, 3 * seen[0].g);  // other wavelengths are reflected
  EXPECT_NEAR(seen[1].g / seen[2].g, 1, 0.03);
}

// Films without thickness or weight, by factor or texture, change nothing.
TEST_F(Iridescence, NoThicknessIsNoIridescence) {
  SceneBuilder builder;
  const uint32_t black = builder.texture(2, 2, false, [](float, float) { return glm::vec4(0, 0, 0, 1); });
  std::vector<Tile> tiles;
  for (const float metallic : {0.0f, 0.5f, 1.0f}) {
    scene::Material plain = coated(0.6f, metallic, 0.3f, 1.6f, 400);
    plain.iridescence = 0;
    tiles.push_back({"plain", plain});
    tiles.push_back({"no thickness", coated(0.6f, metallic, 0.3f, 1.6f, 0)});
    tiles.push_back({"no thickness by texture", coated(0.6f, metallic, 0.3f, 1.6f, 400)});
    tiles.back().material.iridescence_thickness_texture.texture = black;
    tiles.back().material.iridescence_thickness_min_nm = 0;
    tiles.push_back({"no weight by texture", coated(0.6f, metallic, 0.3f, 1.6f, 400)});
    tiles.back().material.iridescence_texture.texture = black;
    tiles.push_back({"film", coated(0.6f, metallic, 0.3f, 1.6f, 400)});
    tiles.push_back({"the same film by texture", coated(0.6f, metallic, 0.3f, 1.6f, 900)});
    tiles.back().material.iridescence_thickness_texture.texture = black;
    tiles.back().material.iridescence_thickness_min_nm = 400;
  }
  const std::vector<glm::dvec3> seen = lit_tiles(builder, tiles, towards(30, 0), towards(35, 180), false);
  for (size_t first = 0; first < tiles.size(); first += 6) {
    const std::string what = ", metallic " + std::to_string(tiles[first].material.metallic);
    for (size_t i = 1; i < 4; ++i) EXPECT_EQ(seen[first + i], seen[first]) << tiles[i].name << what;
    EXPECT_EQ(seen[first + 5], seen[first + 4]) << what;
    EXPECT_GT(glm::length(seen[first + 4] - seen[first]), 0.01) << what;
  }
}

// A slab of glass with a film on both faces, which reflects inside as much as outside. What a channel does
// not reflect enters; all reflections between the faces add up.
TEST_F(Iridescence, FilmReflectsOnBothSides) {
  const double ior = 1.7, film_ior = 1.35, thickness_nm = 380, f0 = std::pow((ior - 1) / (ior + 1), 2);
  scene::Material material = coated(1, 0, 0, static_cast<float>(film_ior), static_cast<float>(thickness_nm));
  material.ior = static_cast<float>(ior);
  material.transmission = 1;
  material.thickness = 1;
  for (const double degrees : {50.0}) {
    SceneBuilder builder;
    builder.mesh_node("slab", builder.box(builder.material(material), {100, 1, 100}), glm::mat4(1));
    constexpr float kDistance = 300;
    builder.camera_node("camera", kDistance * glm::vec3(towards(degrees, 0)) + glm::vec3(0, 0, 0.3f),
                        {0, 0, 0}, 2e-3f);
    const scene::Scene scene = builder.build();
    const glm::dvec3 f = film_reflectance(film_ior, thickness_nm, f0, std::cos(glm::radians(degrees)));
    for (const bool from_above : {false, true}) {
      settings::DrawSettings settings = path_settings(64, 64);
      settings.environment_intensity = 1;
      settings.environment = std::make_shared<scene::EnvironmentImage>(
          scene::make_environment(64, 32, [&](const glm::vec3& direction) {
            return glm::vec3((direction.y > 0) == from_above ? 1.0f : 0.0f);
          }));
      const auto pixels = linear_image(scene, {16, 16}, settings);
      for (int c = 0; c < 3; ++c) {
        const double passed = std::pow(1 - f[c], 2) / (1 - f[c] * f[c]);
        const Estimate seen = estimate(pixels, c);
        const double truth = from_above ? f[c] * (1 + passed) : passed;
        EXPECT_NEAR(seen.mean, truth, 4 * seen.error + 0.005 * truth + 1e-4)
            << (from_above ? "reflected, " : "passed, ") << degrees << " degrees, channel " << c;
        EXPECT_LT(seen.error, 0.01);
      }
    }
  }
}

// A film absorbs nothing: each channel that it does not reflect enters. Bounds: docs/design/materials.md.
TEST_F(Iridescence, WhiteFurnaceGainsNoLight) {
  std::vector<Tile> tiles;
  for (const float metallic : {1.0f, 0.0f}) {
    for (const float roughness : {0.1f, 0.5f, 1.0f}) {
      for (const float thickness_nm : {150.0f, 450.0f})
        tiles.push_back({"metallic " + std::to_string(metallic) + ", roughness " + std::to_string(roughness) +
                             ", thickness " + std::to_string(thickness_nm),
                         coated(1, metallic, roughness, 1.8f, thickness_nm)});
    }
  }
  double least = 2, most = 0;
  for (const double degrees : {15.0, 70.0}) {
    const auto pixels = tile_pixels({}, tiles, towards(degrees, 0), furnace_settings(64));
    for (size_t i = 0; i < tiles.size(); ++i) {
      const MeanRadiance seen = mean_radiance(pixels[i]);
      const std::string what = tiles[i].name + ", " + std::to_string(degrees) + " degrees";
      RecordProperty(what, std::to_string(seen.mean.r) + " " + std::to_string(seen.mean.g) + " " +
                               std::to_string(seen.mean.b) + " +- " + std::to_string(seen.error.g));
      for (int c = 0; c < 3; ++c) {
        EXPECT_LE(seen.mean[c], 1.02 + 4 * seen.error[c]) << what << ", channel " << c;
        EXPECT_GE(seen.mean[c], 0.98 - 4 * seen.error[c]) << what << ", channel " << c;
        EXPECT_LT(seen.error[c], 0.01) << what;
        least = std::min(least, seen.mean[c]);
        most = std::max(most, seen.mean[c]);
      }
    }
  }
  RecordProperty("smallest", std::to_string(least));
  RecordProperty("largest", std::to_string(most));
}

TEST_F(Iridescence, BallsInTheStudio) {
  SceneBuilder builder;
  const uint32_t ramp = builder.texture(4, 64, false, [](float, float v) { return glm::vec4(1, v, 0, 1); });
  // Both faces of the film reflect alike, which makes the colours strongest: a bubble of a dense liquid.
  scene::Material bubble = coated(0.02f, 0, 0.05f, 1.8f, 600);
  bubble.ior = 1;
  bubble.iridescence_thickness_min_nm = 150;
  bubble.iridescence_thickness_texture.texture = ramp;  // thicker towards the bottom
  float x = -2;
  for (const scene::Material& material :
       {coated(0.6f, 1, 0.2f, 1.5f, 450), bubble, coated(0.02f, 0, 0.2f, 1.9f, 300)}) {
    builder.mesh_node("ball", builder.sphere(builder.material(material), 0.9f), at({x, 0, 0}));
    x += 2;
  }
  builder.light_node(sun({1, 0.97f, 0.92f}, 1), shining_towards({-0.3f, -0.5f, -1}));
  builder.camera_node("camera", {0, 0, 8}, {0, 0, 0}, 0.28f);
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings;
  settings.background.show_environment = true;
  settings.shadows.method = settings::ShadowMethod::off;
  settings.raster = settings::RasterPath::visibility;
  const sinks::FrameImage drawn = RenderBench(scene, {320, 120}, settings).draw_at_rest();
  EXPECT_TRUE(matches_golden(drawn, "iridescent_balls", Tolerance::colour()));
  settings.raster = settings::RasterPath::forward;
  EXPECT_TRUE(matches_image(RenderBench(scene, {320, 120}, settings).draw_at_rest(), drawn,
                            "iridescent_balls_forward", Tolerance::colour()));
}

// A dielectric and a metal, so far apart that neither hides much of the environment from the other.
TEST_F(Iridescence, EnvironmentLightMatchesPaths) {
  SceneBuilder builder;
  for (const float metallic : {0.0f, 1.0f})
    builder.mesh_node("ball",
                      builder.sphere(builder.material(coated(0.5f, metallic, 0.3f, 1.7f, 350)), 1, 64),
                      at({metallic > 0 ? 4.0f : -4.0f, 0, 0}));
  builder.camera_node("camera", {0, 1, 16}, {0, 0, 0}, 0.35f);
  const scene::Scene scene = builder.build();
  constexpr VkExtent2D kExtent{64, 32};
  glm::dvec3 means[2][2] = {};  // by metallic, paths
  for (const bool paths : {false, true}) {
    settings::DrawSettings settings = dark_settings(paths);
    if (paths) settings.path->samples_per_pixel = 64;
    settings.environment_intensity = 1;
    const std::vector<glm::dvec3> pixels = linear_image(scene, kExtent, settings);
    for (size_t i = 0; i < pixels.size(); ++i)
      means[i % kExtent.width < kExtent.width / 2 ? 0 : 1][paths] += pixels[i];
  }
  for (int metallic = 0; metallic < 2; ++metallic) {
    for (int c = 0; c < 3; ++c) {
      const std::string what = "metallic " + std::to_string(metallic) + ", channel " + std::to_string(c);
      const double quotient = means[metallic][1][c] / means[metallic][0][c];
      RecordProperty(what, std::to_string(quotient));
      EXPECT_NEAR(quotient, 1, 0.05) << what;
    }
  }
}

}  // namespace
}  // namespace fire3dv::test
