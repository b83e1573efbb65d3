// Panel layout of the user, and its settings file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"

namespace fire3dv::gui {

enum class Panel : uint8_t {
  tree,
  node,
  cameras,
  frame,
  streams,
  lights,
  materials,
  render,
  log,
  timeline,
  joints,
  plots,
  measure,
  edit,
  controls
};
constexpr size_t kPanels = 15;
const char* panel_name(Panel panel);  // one lowercase word
// Sides of the window that panels are docked to.
enum class Dock : uint8_t { left, right, bottom };
constexpr size_t kDocks = 3;

// Sizes are in points: pixels of a display of scale 1.
struct Layout {
  float left_pt = 264, right_pt = 316, log_pt = 132;
  std::array<bool, kPanels> open{true, true, true, true,  true, false, false, true,
                                 true, true, true, false, true, false, true};
  std::array<bool, kDocks> folded{};  // a folded dock is a narrow strip
  float camera_speed = 1;
  bool is_light = false;     // theme
  bool has_plotted = false;  // the first scalars have unfolded the panel Plots, once for all runs

  bool& is_folded(Dock dock) { return folded[static_cast<size_t>(dock)]; }
  bool is_folded(Dock dock) const { return folded[static_cast<size_t>(dock)]; }
  bool& is_open(Panel panel) { return open[static_cast<size_t>(panel)]; }
  bool is_open(Panel panel) const { return open[static_cast<size_t>(panel)]; }
  bool operator==(const Layout&) const = default;
};
constexpr float kLeastColumnPt = 180, kMaxColumnPt = 720, kLeastLogPt = 60, kMaxLogPt = 720;

// Text form: one setting per line. Missing settings keep their defaults; invalid lines are errors.
std::string layout_text(const Layout& layout);
Result<Layout> parse_layout(std::string_view text);

// Path below XDG_CONFIG_HOME or ~/.config; nothing if neither is known.
std::optional<std::filesystem::path> layout_place(const std::function<const char*(const char*)>& environment);
// Returns the defaults if there is no file. Fails for a damaged file.
Result<Layout> load_layout(const std::filesystem::path& file);
// Replaces the file atomically. Creates its folder.
Result<void> save_layout(const std::filesystem::path& file, const Layout& layout);

}  // namespace fire3dv::gui
