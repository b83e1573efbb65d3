// Options of command lines for draw settings, from their table (renderer/settings/setting_table.h).
#pragma once

#include "renderer/app/options/options.h"

namespace CLI {
class App;
}

namespace fire3dv::app {

constexpr const char* kDrawingGroup = "Drawing";
constexpr const char* kOpticsGroup = "Optics and sensor";

// Adds the settings of a group that this user sets. The defaults are those of `draw`, which outlives the
// parsing. title: of the section in --help.
void add_draw_settings(CLI::App& app, settings::SettingUser user, settings::SettingGroup group,
                       const char* title, settings::DrawSettings& draw);
// Adds those of the look of images, with environment map and key light. options: outlives the parsing.
void add_drawing_options(CLI::App& app, settings::SettingUser user, Options& options);

}  // namespace fire3dv::app
