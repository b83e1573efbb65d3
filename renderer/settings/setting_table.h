// Table of the draw settings: name, type, range, help and effect of each. Command lines, configuration files,
// panels, the live view, undo and SceneRenderer::apply() read it, so that a new setting is one row
// (setting_table.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/settings/draw_settings.h"

namespace fire3dv::settings {

// Most expensive consequence of a change, in ascending order.
enum class Invalidates : uint8_t {
  nothing,    // the image stays the same
  post,       // tone mapping and later passes
  shading,    // the image, with the pipelines of the renderer
  pipelines,  // pipelines that the renderer compiles when they are used first
  renderer,   // resources that a renderer creates with itself; see needs_new_renderer()
};

// Programs and interfaces that set a setting, as bits. A configuration file sets what the command line sets.
enum SettingUser : uint8_t {
  kByCommandLine = 1,
  kByWindow = 2,
  kByBrowser = 4,
  kByBench = 8,
  kByDrake = 16,
};

// Sections of the table, in its order.
enum class SettingGroup : uint8_t { optics, environment, image, paths, raster };

enum class SettingKind : uint8_t {
  choice,  // one of DrawSetting::names
  count,
  number,  // or a word in its place
  text,
};

enum class ControlKind : uint8_t { check, choice, slider, color };

// Control of a row, or of a part of its value, in the window's panel and on the browser's page.
struct SettingControl {
  const char* label = "";  // unique; indented below the control that it belongs to
  const char* hint = nullptr;
  std::vector<const char*> names = {};  // of a choice, in the order of `values`; none: a check box
  float least = 0, most = 1;            // of a slider, which a configuration file may exceed
  const char* format = "%.2f";
  bool is_logarithmic = false;
  std::function<bool(const DrawSettings&)> is_shown = {};  // none: always

  // Set by the table; of the row where the control has its whole value.
  ControlKind kind = ControlKind::slider;
  std::vector<std::string> values = {};  // of a choice; of a check box: set, cleared
  std::function<std::string(const DrawSettings&)> text = {};
  std::function<std::string(const std::string& text, DrawSettings&)> set = {};  // as DrawSetting::set
  std::function<glm::vec3&(DrawSettings&)> color = {};  // linear, unrounded; `text` has 8 bits per channel
};

struct DrawSetting {
  std::string name;        // option of command lines and configuration files, without dashes
  std::string value_name;  // stands for the value in --help
  std::string help;
  SettingGroup group = SettingGroup::image;
  SettingKind kind = SettingKind::text;
  Invalidates invalidates = Invalidates::shading;
  uint8_t users = 0;                      // SettingUser
  std::vector<std::string> names;         // of a choice
  float min_number = 0, max_number = 0;   // of a number
  uint32_t min_count = 0, max_count = 0;  // of a count
  bool shows_default = true;              // in --help
  bool needs_paths = false;               // has no effect without path tracing
  bool needs_raster = false;              // has no effect on path-traced images
  bool is_preset = false;                 // sets other rows, and has no value of its own
  std::vector<SettingControl> controls;   // of windows and pages, where these may set it

  std::function<std::string(const DrawSettings&)> text;
  // Returns an error text for an invalid value, else an empty one. An error changes nothing.
  std::function<std::string(const std::string& text, DrawSettings&)> set;
  std::function<bool(const DrawSettings&, const DrawSettings&)> is_same;
  std::function<void(const DrawSettings& from, DrawSettings& to)> copy;
};

const std::vector<DrawSetting>& draw_setting_table();
// name: that of a row.
const DrawSetting& draw_setting(std::string_view name);

// Index of the value of a choice or check box among `values`.
size_t chosen_index(const SettingControl& control, const DrawSettings& settings);
// True unless the control, or its row, has no meaning beside the other settings.
bool is_shown(const DrawSetting& setting, const SettingControl& control, const DrawSettings& settings);
inline bool is_enabled(const DrawSetting& setting, const DrawSettings& settings) {
  return !(setting.needs_raster && settings.path);
}

// Paths that a change of `draw` starts get the last settings of paths, which are kept in `paths`.
// traced_paths: before the change.
void keep_path_settings(bool traced_paths, DrawSettings& draw, PathSettings& paths);

// Defaults of the programs: DrawSettings{} with tone mapping, background and exposure of the default look.
DrawSettings default_settings();

// Most expensive consequence of the change from one to the other, of settings in the table.
Invalidates compare(const DrawSettings& from, const DrawSettings& to);
// True if a renderer of some device made with these settings cannot apply() the others.
inline bool needs_new_renderer(const DrawSettings& made_with, const DrawSettings& settings) {
  return compare(made_with, settings) == Invalidates::renderer;
}
// Copies what a renderer can change: all but the settings that need a new one, and its resources.
void copy_applicable(const DrawSettings& from, DrawSettings& to);

// True if all settings of the table are the same that these users change. users: SettingUser bits.
bool have_same_values(const DrawSettings& a, const DrawSettings& b, uint8_t users);

// Shortest text without exponent that is read as the same number.
std::string number_text(float value);
// Checks of numbers, which accept neither NaN nor infinity. They return an error text, or an empty one.
std::string positive_number(const std::string& text);
std::string finite_number(const std::string& text);

}  // namespace fire3dv::settings
