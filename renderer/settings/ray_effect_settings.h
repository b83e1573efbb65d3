// Settings of ray effects: rays of the raster image beside those to lights (docs/ray-effects.md).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "renderer/settings/shadow_settings.h"

namespace fire3dv::settings {

struct RayEffects {
  bool reflections = false;
  bool ambient_occlusion = false;
  bool refraction = false;
  bool bounce = false;  // diffuse
  bool any() const { return reflections || ambient_occlusion || refraction || bounce; }
  bool operator==(const RayEffects&) const = default;
};

struct RayEffectSettings {
  RayEffects on;
  uint32_t reflection_rays = 4;  // reflected or refracted at a rough surface in a pixel; smooth ones take one
  uint32_t occlusion_rays = 4;   // of a pixel; with a bounce, its rays find the occlusion
  uint32_t bounce_rays = 4;      // diffuse, of a pixel
  void set_rays(uint32_t count) { reflection_rays = occlusion_rays = bounce_rays = count; }
  float occlusion_distance_m = 0;           // length of these rays; 0: a tenth of the scene's radius
  RayBackEnd back_end = RayBackEnd::query;  // preferred; the other one is the fallback
};

// Effects of an option, shared by all programs: "off", "all", or names separated by commas. False for an
// unknown name.
bool ray_effects_named(std::string_view names, RayEffects& effects);
// Names of these effects, separated by commas.
std::string describe(const RayEffects& effects);
// The same for all effects.
std::string ray_effect_names();

}  // namespace fire3dv::settings
