#include "renderer/app/options/appearance_options.h"

#include <algorithm>
#include <array>
#include <string>

#include "renderer/settings/setting_table.h"

namespace fire3dv::app {
namespace {

// Beside the table of draw settings.
constexpr std::array<std::string_view, 9> kNames{"size",    "camera",  "frame-all", "ground", "key-light",
                                                 "markers", "animate", "variant",   "view"};

bool has_effect(const settings::DrawSetting& setting, const settings::DrawSettings& draw) {
  return (setting.users & settings::kByCommandLine) && (!setting.needs_paths || draw.path) &&
         settings::is_enabled(setting, draw);
}

std::string ground_text(const Options& options) {
  return options.ground == GroundMode::off ? "off" : settings::number_text(options.ground_height_m);
}

}  // namespace

sinks::RunProvenance::Values appearance_options(const Options& options) {
  sinks::RunProvenance::Values values;
  values.emplace_back("size", std::to_string(options.width) + "x" + std::to_string(options.height));
  if (!options.camera.empty()) values.emplace_back("camera", options.camera);
  if (options.frame_all) values.emplace_back("frame-all", "");
  if (options.ground != GroundMode::automatic) values.emplace_back("ground", ground_text(options));
  if (options.key_light != KeyLight::automatic)
    values.emplace_back("key-light", options.key_light == KeyLight::on ? "on" : "off");
  if (!options.markers || options.markers_in_data_sets)
    values.emplace_back("markers", options.markers ? "all" : "off");
  if (!options.animate.empty()) values.emplace_back("animate", options.animate);
  if (!options.variant.empty()) values.emplace_back("variant", options.variant);
  if (options.debug_view != settings::DebugView::none)
    values.emplace_back("view", settings::kDebugViewNames[static_cast<size_t>(options.debug_view)]);
  const settings::DrawSettings defaults = settings::default_settings();
  for (const settings::DrawSetting& setting : settings::draw_setting_table()) {
    if (!has_effect(setting, options.draw)) continue;
    std::string text = setting.text(options.draw);
    if (text != setting.text(defaults)) values.emplace_back(setting.name, std::move(text));
  }
  return values;
}

bool is_appearance_option(std::string_view name) {
  const auto& table = settings::draw_setting_table();
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end() ||
         std::any_of(table.begin(), table.end(), [&](const settings::DrawSetting& setting) {
           return setting.name == name && (setting.users & settings::kByCommandLine);
         });
}

}  // namespace fire3dv::app
