#include "tests/render/support/material_tiles.h"

#include <cmath>
#include <glm/gtc/packing.hpp>
#include <memory>

#include "renderer/scene/textures/environment.h"
#include "tests/render/support/render_bench.h"

namespace fire3dv::test {

settings::DrawSettings dark_settings(bool paths) {
  settings::DrawSettings settings;
  settings.environment_intensity = 0;
  settings.background.color = glm::vec3(0);
  settings.shadows.method = settings::ShadowMethod::off;
  settings.post.fxaa = false;
  if (paths) settings.path = settings::PathSettings{.samples_per_pixel = 4, .bounces = 0, .seed = 1};
  return settings;
}

settings::DrawSettings furnace_settings(uint32_t samples_per_pixel) {
  settings::DrawSettings settings = dark_settings(true);
  settings.path = settings::PathSettings{.samples_per_pixel = samples_per_pixel, .bounces = 1, .seed = 1};
  settings.environment = std::make_shared<scene::EnvironmentImage>(
      scene::make_environment(16, 8, [](const glm::vec3&) { return glm::vec3(1); }));
  settings.environment_intensity = 1;
  return settings;
}

glm::dvec3 towards(double degrees, double turn_degrees) {
  const double s = std::sin(glm::radians(degrees)), turn = glm::radians(turn_degrees);
  return {s * std::cos(turn), std::cos(glm::radians(degrees)), s * std::sin(turn)};
}

std::vector<std::vector<glm::dvec3>> tile_pixels(SceneBuilder builder, const std::vector<Tile>& tiles,
                                                 const glm::dvec3& to_eye,
                                                 const settings::DrawSettings& settings) {
  const auto count = static_cast<uint32_t>(tiles.size());
  const auto center = [&](uint32_t tile) {
    return glm::vec3(2 * static_cast<float>(tile) - static_cast<float>(count - 1), 0, 0);
  };
  for (uint32_t i = 0; i < count; ++i)
    builder.mesh_node(tiles[i].name, builder.quad(builder.material(tiles[i].material), 1), at(center(i)));
  const scene::Scene scene = builder.build();
  const state::PoseState poses(scene);
  RenderBench bench(scene, {9, 9}, settings);
  constexpr double kDistance = 2000;
  scene::Camera camera;
  camera.vertical_fov_rad = static_cast<float>(0.02 / kDistance);  // within a tile, also at 89 degrees
  passes::ImageOutputs outputs;
  outputs.add(wire::kColorLinearF16);
  std::vector<std::vector<glm::dvec3>> result(count);
  for (uint32_t i = 0; i < count; ++i) {
    const passes::View view = passes::make_view(
        camera, passes::look_at_pose(center(i) + glm::vec3(kDistance * to_eye), center(i)), 1);
    for (const uint64_t pixel : bench.take(poses, view, outputs).plane<uint64_t>(wire::kColorLinearF16))
      result[i].emplace_back(glm::unpackHalf4x16(pixel));
  }
  return result;
}

std::vector<glm::dvec3> lit_tiles(const SceneBuilder& builder, const std::vector<Tile>& tiles,
                                  const glm::dvec3& to_eye, const glm::dvec3& to_light, bool paths) {
  constexpr double kLux = 3;
  SceneBuilder lamp = builder;
  lamp.light_node(sun({1, 1, 1}, static_cast<float>(kLux)), shining_towards(glm::vec3(-to_light)));
  std::vector<glm::dvec3> result;
  for (const std::vector<glm::dvec3>& pixels : tile_pixels(lamp, tiles, to_eye, dark_settings(paths)))
    result.push_back(pixels[pixels.size() / 2] / (kLux * to_light.y));
  return result;
}

MeanRadiance mean_radiance(const std::vector<glm::dvec3>& pixels) {
  const auto count = static_cast<double>(pixels.size());
  glm::dvec3 sum(0), squares(0);
  for (const glm::dvec3& pixel : pixels) {
    sum += pixel;
    squares += pixel * pixel;
  }
  const glm::dvec3 mean = sum / count;
  return {mean, glm::sqrt(glm::max(squares / count - mean * mean, 0.0) / (count - 1))};
}

}  // namespace fire3dv::test
