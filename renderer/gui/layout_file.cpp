#include "renderer/gui/layout_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/files.h"
#include "base/numbers.h"
#include "base/words.h"

namespace fire3dv::gui {
namespace {

constexpr uint64_t kMaxBytes = 64 << 10;

struct Number {
  const char* name;
  float Layout::*member;
  float least, most;
};
constexpr Number kNumbers[] = {
    {"left", &Layout::left_pt, kLeastColumnPt, kMaxColumnPt},
    {"right", &Layout::right_pt, kLeastColumnPt, kMaxColumnPt},
    {"log-height", &Layout::log_pt, kLeastLogPt, kMaxLogPt},
    {"camera-speed", &Layout::camera_speed, 0.01f, 100},
};

constexpr const char* kDockNames[kDocks] = {"left-dock", "right-dock", "bottom-dock"};

constexpr const char* kThemeName = "theme";
constexpr const char* kPlottedName = "scalars-seen";
constexpr const char* kThemes[] = {"dark", "light"};

// Returns false for an unknown setting.
bool set(Layout& layout, std::string_view name, std::string_view value) {
  for (const Number& number : kNumbers) {
    if (name != number.name) continue;
    const std::optional<float> parsed = parse_number<float>(value);
    if (!parsed || !std::isfinite(*parsed)) return false;
    layout.*number.member = std::clamp(*parsed, number.least, number.most);
    return true;
  }
  if (name == kThemeName) {
    layout.is_light = value == kThemes[1];
    return layout.is_light || value == kThemes[0];
  }
  if (name == kPlottedName) {
    layout.has_plotted = value == "yes";
    return layout.has_plotted || value == "no";
  }
  for (size_t i = 0; i < kPanels; ++i) {
    if (name != panel_name(static_cast<Panel>(i))) continue;
    if (value != "open" && value != "closed") return false;
    layout.open[i] = value == "open";
    return true;
  }
  for (size_t i = 0; i < kDocks; ++i) {
    if (name != kDockNames[i]) continue;
    if (value != "open" && value != "folded") return false;
    layout.folded[i] = value == "folded";
    return true;
  }
  return false;
}

}  // namespace

const char* panel_name(Panel panel) {
  constexpr const char* kNames[kPanels] = {"scene",  "node",      "cameras", "frame", "streams",
                                           "lights", "materials", "render",  "log",   "timeline",
                                           "joints", "plots",     "measure", "edit",  "controls"};
  return kNames[static_cast<size_t>(panel)];
}

std::string layout_text(const Layout& layout) {
  std::string text = "# How the panels of FIRE-3DV's window are arranged; sizes in points.\n";
  char line[64];
  for (const Number& number : kNumbers) {
    std::snprintf(line, sizeof line, "%s = %g\n", number.name, static_cast<double>(layout.*number.member));
    text += line;
  }
  text += std::string(kThemeName) + " = " + kThemes[layout.is_light ? 1 : 0] + "\n";
  text += std::string(kPlottedName) + (layout.has_plotted ? " = yes\n" : " = no\n");
  for (size_t i = 0; i < kPanels; ++i) {
    text += std::string(panel_name(static_cast<Panel>(i))) + (layout.open[i] ? " = open\n" : " = closed\n");
  }
  for (size_t i = 0; i < kDocks; ++i)
    text += std::string(kDockNames[i]) + (layout.folded[i] ? " = folded\n" : " = open\n");
  return text;
}

Result<Layout> parse_layout(std::string_view text) {
  Layout layout;
  for (int number = 1; !text.empty(); ++number) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line.front() == '#') continue;
    const size_t equals = line.find('=');
    if (equals == std::string_view::npos ||
        !set(layout, trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1)))) {
      return Error{"line " + std::to_string(number) + " is not a setting of the window"};
    }
  }
  return layout;
}

std::optional<std::filesystem::path> layout_place(
    const std::function<const char*(const char*)>& environment) {
  // The XDG specification requires that relative paths are ignored.
  const auto absolute = [&](const char* name) {
    const char* value = environment(name);
    return std::filesystem::path(value && *value == '/' ? value : "");
  };
  if (const auto config = absolute("XDG_CONFIG_HOME"); !config.empty())
    return config / "fire3dv" / "window.conf";
  if (const auto home = absolute("HOME"); !home.empty()) return home / ".config" / "fire3dv" / "window.conf";
  return std::nullopt;
}

Result<Layout> load_layout(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return Layout{};
  constexpr const char* kRemedy = "; the panels are arranged as they are at first";
  const Result<std::vector<uint8_t>> bytes = read_whole_file(file, kMaxBytes);
  if (!bytes) return Error{bytes.error().message + kRemedy};
  Result<Layout> layout = parse_layout({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  if (!layout) return Error{file.string() + ": " + layout.error().message + kRemedy};
  return layout;
}

Result<void> save_layout(const std::filesystem::path& file, const Layout& layout) {
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  if (error) return Error{file.string() + ": its folder cannot be made: " + error.message()};
  const std::string text = layout_text(layout);
  return write_whole_file(file, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace fire3dv::gui
