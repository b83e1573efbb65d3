#include "renderer/settings/draw_settings.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace fire3dv::settings {
namespace {

struct NamedEffect {
  std::string_view name;
  bool RayEffects::*on;
};
constexpr NamedEffect kEffects[] = {{"reflections", &RayEffects::reflections},
                                    {"ao", &RayEffects::ambient_occlusion},
                                    {"refraction", &RayEffects::refraction},
                                    {"bounce", &RayEffects::bounce}};

}  // namespace

Background Background::gradient() {
  Background background;
  background.color = {0.46f, 0.48f, 0.51f};
  background.zenith = glm::vec3(0.085f, 0.105f, 0.135f);
  return background;
}

Background Background::automatic() {
  Background background = gradient();
  background.show_sky = true;
  return background;
}

std::optional<DrawSettings> settings_in_motion(const DrawSettings& at_rest) {
  const bool fewer_samples = !at_rest.keeps_samples && at_rest.samples > 1;
  const bool maps_alone = at_rest.shadows == ShadowSettings();
  if (at_rest.motion_quality == MotionQuality::full || at_rest.path || (!fewer_samples && !maps_alone))
    return std::nullopt;
  DrawSettings reduced = at_rest;
  if (fewer_samples) reduced.samples = 1;
  if (maps_alone) reduced.shadows.method = ShadowMethod::map;
  return reduced;
}

bool ray_effects_named(std::string_view names, RayEffects& effects) {
  effects = {};
  if (names == "off") return true;
  while (true) {
    const size_t comma = names.find(',');
    const std::string_view name = names.substr(0, comma);
    bool known = false;
    for (const NamedEffect& effect : kEffects) {
      if (name != effect.name && name != "all") continue;
      effects.*effect.on = true;
      known = true;
    }
    if (!known) return false;
    if (comma == std::string_view::npos) return true;
    names.remove_prefix(comma + 1);
  }
}

std::string describe(const RayEffects& effects) {
  std::string names;
  for (const NamedEffect& effect : kEffects) {
    if (effects.*effect.on) names += (names.empty() ? "" : ", ") + std::string(effect.name);
  }
  return names;
}

std::string ray_effect_names() {
  RayEffects all;
  (void)ray_effects_named("all", all);
  return describe(all);
}

}  // namespace fire3dv::settings
