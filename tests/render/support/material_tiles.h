// Tiles of materials side by side, seen from far away in one direction: radiances under one lamp or an
// environment.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "renderer/passes/scene_renderer.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {

// The tiles lie along +X and face +Y. Their tangents are +X, their bitangents +Z.
struct Tile {
  std::string name;
  scene::Material material;
};

// No environment, no background, no shadows. paths: direct light by path tracing.
settings::DrawSettings dark_settings(bool paths);
// Radiance 1 from everywhere, one reflection by path tracing.
settings::DrawSettings furnace_settings(uint32_t samples_per_pixel);

// Unit direction at an angle from +Y, turned about it from +X towards +Z.
glm::dvec3 towards(double degrees, double turn_degrees);

// Pixels of the middle of each tile.
std::vector<std::vector<glm::dvec3>> tile_pixels(SceneBuilder builder, const std::vector<Tile>& tiles,
                                                 const glm::dvec3& to_eye,
                                                 const settings::DrawSettings& settings);

// Radiance of each tile per irradiance under a directional lamp.
std::vector<glm::dvec3> lit_tiles(const SceneBuilder& builder, const std::vector<Tile>& tiles,
                                  const glm::dvec3& to_eye, const glm::dvec3& to_light, bool paths);

struct MeanRadiance {
  glm::dvec3 mean, error;  // standard error
};
MeanRadiance mean_radiance(const std::vector<glm::dvec3>& pixels);

}  // namespace fire3dv::test
