// Render tests of the material model under lamps: white furnace and reciprocity. Lamps are directions of a
// quadrature over the sphere, weighted by their solid angle, so that their sum is a uniform environment of
// radiance
// 1. A white surface then shows 1, whatever its roughness, metalness and view.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr double kPi = 3.14159265358979;
constexpr uint32_t kTilePixels = 9;

struct Lamp {
  glm::dvec3 to_light;
  double solid_angle_sr;
};

double radical_inverse(uint32_t i) {
  double value = 0, digit = 0.5;
  for (; i != 0; i >>= 1, digit /= 2) value += (i & 1) * digit;
  return value;
}

double ggx(double n_dot_h, double alpha) {
  const double d = n_dot_h * n_dot_h * (alpha * alpha - 1) + 1;
  return alpha * alpha / (kPi * d * d);
}

// Directions above a surface with the normal +Y, half of them distributed as the cosine, half as the mirror
// images of `to_eye` in GGX facets; weighted by the density of both (balance heuristic: Veach and Guibas
// 1995). Each one also comes from below, mirrored.
std::vector<Lamp> furnace_lamps(const glm::dvec3& to_eye, double alpha, uint32_t count) {
  std::vector<Lamp> lamps;
  for (uint32_t i = 0; i < 2 * count; ++i) {
    const double u = (i / 2 + 0.5) / count, angle = 2 * kPi * radical_inverse(i / 2);
    const bool by_facet = i % 2 == 1;
    const double cosine = by_facet ? std::sqrt((1 - u) / (1 + (alpha * alpha - 1) * u)) : std::sqrt(1 - u);
    const double sine = std::sqrt(1 - cosine * cosine);
    glm::dvec3 direction(sine * std::cos(angle), cosine, sine * std::sin(angle));
    if (by_facet) direction = 2 * glm::dot(to_eye, direction) * direction - to_eye;
    if (direction.y <= 1e-4) continue;
    const glm::dvec3 half = glm::normalize(direction + to_eye);
    const double facet_density = ggx(half.y, alpha) * half.y / (4 * glm::dot(half, to_eye));
    const double density = (direction.y / kPi + facet_density) / 2;
    lamps.push_back({direction, 1 / (2 * count * density)});
    lamps.push_back({{direction.x, -direction.y, direction.z}, 1 / (2 * count * density)});
  }
  return lamps;
}

struct Tile {
  std::string name;
  scene::Material material;
  double least = 0.99, most = 1.01;  // accepted radiance
};

scene::Material white(float metallic, float roughness) {
  scene::Material material = matte(glm::vec3(1));
  material.metallic = metallic;
  material.roughness = roughness;
  return material;
}

// Radiance of each tile, seen from far away in this direction. The tiles lie side by side and face +Y.
std::vector<double> radiances(const std::vector<Tile>& tiles, glm::dvec3 to_eye,
                              const std::vector<Lamp>& lamps) {
  // Turned about the normal until the row of tiles lies across the image.
  const double turn = std::atan2(to_eye.z, to_eye.x) - kPi / 2, c = std::cos(turn), s = std::sin(turn);
  const auto turned = [&](const glm::dvec3& d) {
    return glm::dvec3(c * d.x + s * d.z, d.y, c * d.z - s * d.x);
  };
  to_eye = turned(to_eye);
  SceneBuilder builder;
  const auto count = static_cast<uint32_t>(tiles.size());
  for (uint32_t i = 0; i < count; ++i) {
    const float x = 2 * static_cast<float>(i) - static_cast<float>(count - 1);
    builder.mesh_node(tiles[i].name, builder.quad(builder.material(tiles[i].material), 1),
                      at({x, 0, 0}) * glm::scale(glm::mat4(1), glm::vec3(1, 1, 20)));
  }
  for (const Lamp& lamp : lamps)
    builder.light_node(sun({1, 1, 1}, static_cast<float>(lamp.solid_angle_sr)),
                       shining_towards(glm::vec3(-turned(lamp.to_light))));
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings;
  settings.environment_intensity = 0;
  settings.background.color = glm::vec3(0);
  settings.shadows.method = settings::ShadowMethod::off;
  settings.post.fxaa = false;
  const VkExtent2D extent{count * kTilePixels, kTilePixels};
  RenderBench bench(scene, extent, settings);
  const state::PoseState poses(scene);
  constexpr double kDistance = 20000;  // one direction for all tiles
  scene::Camera camera;
  camera.vertical_fov_rad = static_cast<float>(2 * std::atan(1 / kDistance));
  const passes::View view = passes::make_view(
      camera, passes::look_at_pose(glm::vec3(kDistance * to_eye), {0, 0, 0}), static_cast<float>(count));
  passes::ImageOutputs outputs;
  outputs.add(wire::kColorLinearF16);
  const auto pixels = bench.take(poses, view, outputs).plane<uint64_t>(wire::kColorLinearF16);
  std::vector<double> result;
  for (uint32_t i = 0; i < count; ++i) {
    const size_t middle = size_t{kTilePixels / 2} * extent.width + i * kTilePixels + kTilePixels / 2;
    result.push_back(glm::unpackHalf4x16(pixels[middle]).g);
  }
  return result;
}

glm::dvec3 towards(double degrees, double turn_degrees = 90) {
  const double s = std::sin(glm::radians(degrees));
  return {s * std::cos(glm::radians(turn_degrees)), std::cos(glm::radians(degrees)),
          s * std::sin(glm::radians(turn_degrees))};
}

std::vector<Tile> tiles_of(float roughness) {
  std::vector<Tile> tiles{{"metal", white(1, roughness)},
                          {"dielectric", white(0, roughness)},
                          {"half a metal", white(0.5f, roughness)}};
  Tile dense{"ior 2.4", white(0, roughness)};
  dense.material.ior = 2.4f;
  tiles.push_back(dense);
  Tile pane{"transmission", white(0, roughness)};
  pane.material.transmission = 1;
  tiles.push_back(pane);
  // A specular lobe below a layer loses a little: the layer's share of light is the smaller of the two
  // directions'.
  Tile coated{"coated plastic", white(0, roughness), 0.98, 1.01};
  coated.material.clearcoat = 1;
  coated.material.clearcoat_roughness = roughness;
  tiles.push_back(coated);
  Tile coated_metal{"coated metal", white(1, roughness), 0.95, 1.01};
  coated_metal.material.clearcoat = 1;
  coated_metal.material.clearcoat_roughness = roughness;
  tiles.push_back(coated_metal);
  Tile cloth{"cloth", white(0, 0.8f), 0.97, 1.015};
  cloth.material.sheen_color = glm::vec3(1);
  cloth.material.sheen_roughness = std::max(roughness, 0.3f);
  tiles.push_back(cloth);
  return tiles;
}

class WhiteFurnace : public ValidationIsSilent {};

TEST_F(WhiteFurnace, WhiteSurfacesShowLampRadiance) {
  for (const float roughness : {0.1f, 0.3f, 0.5f, 0.7f, 1.0f}) {
    const std::vector<Tile> tiles = tiles_of(roughness);
    for (const double degrees : {10.0, 45.0, 66.0, 81.0, 86.0}) {
      const glm::dvec3 to_eye = towards(degrees);
      const std::vector<double> seen =
          radiances(tiles, to_eye, furnace_lamps(to_eye, roughness * roughness, 512));
      for (size_t i = 0; i < tiles.size(); ++i) {
        const std::string what = tiles[i].name + ", roughness " + std::to_string(roughness) + ", " +
                                 std::to_string(degrees) + " degrees";
        EXPECT_GE(seen[i], tiles[i].least) << what;
        RecordProperty(what, std::to_string(seen[i]));
        EXPECT_LE(seen[i], tiles[i].most) << what;
      }
    }
  }
}

// Helmholtz reciprocity: the lamp and the eye can change places.
TEST_F(WhiteFurnace, LampAndEyeAreReciprocal) {
  for (const float roughness : {0.3f, 0.8f}) {
    const std::vector<Tile> tiles = tiles_of(roughness);
    const struct {
      glm::dvec3 a, b;
    } pairs[] = {{towards(20, 90), towards(75, 200)},
                 {towards(80, 90), towards(60, 270)},
                 {towards(5, 10), towards(85, 90)}};
    for (const auto& pair : pairs) {
      const double strength = 2;
      const std::vector<double> forth = radiances(tiles, pair.a, {{pair.b, strength}});
      const std::vector<double> back = radiances(tiles, pair.b, {{pair.a, strength}});
      for (size_t i = 0; i < tiles.size(); ++i) {
        const double there = forth[i] / pair.b.y, here = back[i] / pair.a.y;
        EXPECT_GT(there, 1e-4) << tiles[i].name;
        EXPECT_NEAR(there / here, 1, 0.01) << tiles[i].name << ", roughness " << roughness;
      }
    }
  }
}

}  // namespace
}  // namespace fire3dv::test
