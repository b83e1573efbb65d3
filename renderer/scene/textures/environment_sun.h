// The sun of an environment map: its brightest small lobe, as a directional light beside the rest of the
// image. Light and rest together have the irradiance of the image. How it is found: docs/environment-sun.md.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "renderer/scene/model/appearance.h"
#include "renderer/scene/textures/environment.h"

namespace fire3dv::scene {

struct EnvironmentSun {
  glm::vec3 to_sun{0, 1, 0};       // unit, in the frame of the image
  glm::vec3 illuminance_lux{0};    // of a surface that faces it; linear RGB
  float angular_radius_rad = 0;    // of the disc with the lobe's mean square angle around its centre
  float share_of_illuminance = 0;  // of a surface that faces it, 0 to 1
};

struct SplitEnvironment {
  EnvironmentSun sun;
  EnvironmentImage rest;  // the image with the surroundings' radiance in place of the lobe
};

// Largest angular radius and least share of a sun. Larger lobes are well sampled by prefiltered maps, and
// weaker ones cast shadows that are hardly visible.
constexpr float kMaxSunRadius_rad = 0.0564f;  // 3.2 degrees: 0.01 sr
constexpr float kMinSunShare = 0.05f;

// Nothing if the image has no sun. The result depends on the image alone.
std::optional<SplitEnvironment> split_sun(const EnvironmentImage& image);

// The same as a light of a scene, for an environment of intensity 1.
Light light_of(const EnvironmentSun& sun);

// Unit direction to the sun in the world. rotation_rad: of the environment, about +Y, counter-clockwise seen
// from above.
glm::vec3 world_direction(const EnvironmentSun& sun, float rotation_rad);

// One line for users.
std::string describe(const EnvironmentSun& sun);

}  // namespace fire3dv::scene
