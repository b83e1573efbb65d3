#include "renderer/app/options/drawing_options.h"

#include <CLI/CLI.hpp>

#include "base/command_line.h"
#include "renderer/app/options/option_values.h"

namespace fire3dv::app {
namespace {

passes::ToneMap tone_map_named(const std::string& name) {
  if (name == "reinhard") return passes::ToneMap::reinhard;
  if (name == "aces") return passes::ToneMap::aces;
  if (name == "neutral") return passes::ToneMap::neutral;
  return passes::ToneMap::none;
}

}  // namespace

void add_drawing_options(CLI::App& app, Options& options, DrawingTexts& texts) {
  constexpr const char* kGroup = kDrawingGroup;
  app.add_option("--environment", options.environment,
                 "environment map, equirectangular .hdr or .exr (default: studio)")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--environment-rotation", options.environment_rotation_deg, "degrees, counter-clockwise")
      ->check(finite_number)
      ->type_name("DEG")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--environment-intensity", options.environment_intensity, "factor on its light")
      ->check(number_from_zero)
      ->type_name("X")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--background", texts.background, "gradient, environment, or a colour such as 20a0ff")
      ->type_name("COLOR")
      ->group(kGroup);
  app.add_option("--key-light", texts.key_light, "light of scenes without lights")
      ->check(one_of({"auto", "on", "off"}))
      ->type_name("auto|on|off")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--exposure", texts.exposure, "factor on all light; metered: by each image")
      ->type_name("X|auto|metered")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--tone-map", texts.tone_map, "neutral, aces, reinhard or none")
      ->check(one_of({"reinhard", "aces", "neutral", "none"}))
      ->type_name("NAME")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--shadows", texts.shadows, names_text("by ", passes::kShadowNames))
      ->check(one_of(passes::kShadowNames))
      ->type_name("NAME")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--shadow-rays", texts.shadow_rays, "rays for uncertain pixels, or for all lit ones")
      ->check(one_of({"hybrid", "all"}))
      ->type_name("hybrid|all")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--samples", options.samples, "samples per pixel at most, 1 to 64")
      ->check(CLI::Range(1, 64).description(""))
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--fxaa", texts.fxaa, "post-process antialiasing")
      ->check(one_of({"on", "off"}))
      ->type_name("on|off")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--bloom", options.bloom, "share of light that a lens scatters, 0 to 1")
      ->check(share_number)
      ->type_name("STRENGTH")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--ray-effects", texts.ray_effects, "off, all, or some of reflections,ao,refraction,bounce")
      ->type_name("LIST")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--ray-effect-rays", options.ray_effect_rays, "rays of an effect in a pixel, 1 to 16")
      ->check(CLI::Range(1, 16).description(""))
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--anisotropy", options.anisotropy, "anisotropic texture filtering, 1 to 16")
      ->check(anisotropy_number)
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
}

std::string take_drawing_texts(const DrawingTexts& texts, Options& options) {
  if (!texts.background.empty() && !parse_background(texts.background, options.background))
    return "--background " + texts.background + ": must be gradient, environment or a colour such as 20a0ff";
  options.metered_exposure = texts.exposure == "metered";
  if (texts.exposure != "auto" && !options.metered_exposure) {
    if (const std::string wrong = positive_number(texts.exposure); !wrong.empty())
      return "--exposure: " + wrong + ", auto or metered";
    options.exposure = std::stof(texts.exposure);
  }
  options.shadows = passes::shadows_named(texts.shadows);
  options.shadows.hybrid = texts.shadow_rays == "hybrid";
  options.tone_map = tone_map_named(texts.tone_map);
  if (texts.key_light == "on") options.key_light = KeyLight::on;
  if (texts.key_light == "off") options.key_light = KeyLight::off;
  options.fxaa = texts.fxaa == "on";
  if (!passes::ray_effects_named(texts.ray_effects, options.ray_effects))
    return "--ray-effects " + texts.ray_effects +
           ": must be off, all, or names separated by commas: " + passes::ray_effect_names();
  return "";
}

}  // namespace fire3dv::app
