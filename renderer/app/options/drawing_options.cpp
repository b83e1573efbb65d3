#include "renderer/app/options/drawing_options.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "base/command_line.h"

namespace fire3dv::app {
namespace {

CLI::Option* add_setting(CLI::App& app, const settings::DrawSetting& setting, settings::DrawSettings& draw) {
  const std::string name = "--" + setting.name;
  if (setting.kind == settings::SettingKind::count) {
    const auto set = [&setting, &draw](uint32_t count) { setting.set(std::to_string(count), draw); };
    return app.add_option_function<uint32_t>(name, set, setting.help)
        ->check(in_range(setting.min_count, setting.max_count));
  }
  const auto set = [&setting, &draw, name](const std::string& text) {
    const std::string wrong = setting.set(text, draw);
    if (!wrong.empty()) throw CLI::ValidationError(name + " " + text + ": " + wrong);
  };
  CLI::Option* option = app.add_option_function<std::string>(name, set, setting.help);
  if (setting.kind == settings::SettingKind::choice) option->check(one_of(setting.names));
  if (setting.kind == settings::SettingKind::number) {
    option->check([&setting](const std::string& text) {
      settings::DrawSettings ignored;
      return setting.set(text, ignored);
    });
  }
  return option;
}

}  // namespace

void add_draw_settings(CLI::App& app, settings::SettingUser user, settings::SettingGroup group,
                       const char* title, settings::DrawSettings& draw) {
  for (const settings::DrawSetting& setting : settings::draw_setting_table()) {
    if (setting.group != group || !(setting.users & user)) continue;
    CLI::Option* option = add_setting(app, setting, draw)->type_name(setting.value_name)->group(title);
    if (setting.shows_default) option->default_str(setting.text(draw));
  }
}

void add_drawing_options(CLI::App& app, settings::SettingUser user, Options& options) {
  add_draw_settings(app, user, settings::SettingGroup::optics, kOpticsGroup, options.draw);
  OptionGroup group(app, kDrawingGroup);
  group.add("--environment", options.environment, "FILE",
            "environment map, equirectangular .hdr or .exr (default: studio)");
  add_draw_settings(app, user, settings::SettingGroup::environment, kDrawingGroup, options.draw);
  const auto set_key_light = [&options](const std::string& text) {
    options.key_light = text == "on" ? KeyLight::on : text == "off" ? KeyLight::off : KeyLight::automatic;
  };
  app.add_option_function<std::string>("--key-light", set_key_light, "light of scenes without lights")
      ->check(one_of({"auto", "on", "off"}))
      ->type_name("auto|on|off")
      ->default_str("auto")
      ->group(kDrawingGroup);
  add_draw_settings(app, user, settings::SettingGroup::image, kDrawingGroup, options.draw);
}

}  // namespace fire3dv::app
