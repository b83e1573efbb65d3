// Widget set of the panels with a uniform style. All interactive controls are created here, so that tests can
// find them.
#pragma once

#include <imgui.h>

#include <cmath>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/gui/gui.h"
#include "renderer/gui/theme.h"

namespace fire3dv::gui {

// Replaces line breaks by spaces: rows have the height of one line.
std::string one_line(std::string_view text);

class Ui {
 public:
  float scale = 1;
  bool notes_controls = false;
  std::vector<Control> controls;

  void begin_frame(float display_scale);
  float points(float pt) const { return std::round(pt * scale); }

  // Panel title that toggles the panel. Returns true if open. Subsequent widgets belong to this panel.
  bool header(const char* title, bool& open);
  // Starts a panel without a title.
  void enter(const char* panel) { panel_ = panel; }

  // Label on the left, value on the right.
  void value(const char* label, const char* format, ...) IM_FMTARGS(3);
  void value(const char* label, ImU32 color, const std::string& text);
  void note(const std::string& text);  // dimmed text over the full width

  bool button(const char* label, bool enabled = true, const char* hint = nullptr, bool pressed = false);
  void same_line() { ImGui::SameLine(0, points(4)); }
  // Widgets with a label on the left; return true if the user changed the value.
  bool check(const char* label, bool& value, const char* hint = nullptr);
  struct Range {
    float least, most;
    const char* format = "%.2f";
    bool logarithmic = false;
  };
  bool slider(const char* label, float& value, const Range& range, const char* hint = nullptr);
  bool choice(const char* label, size_t& chosen, std::span<const char* const> names,
              const char* hint = nullptr);
  bool color(const char* label, glm::vec3& linear, const char* hint = nullptr);
  bool text(const char* name, const char* hint, std::string& value);
  // Selectable list row.
  bool row(const char* text, bool chosen, ImU32 text_color = theme::kText, float width = 0);
  // Small icon button at the end of a row.
  bool sign(const char* name, const char* glyph, ImU32 color, float width);
  // Draggable splitter; returns its movement in pixels.
  float edge(const char* name, bool upright, const Rect& rect);

  // Filled curves with a common scale from 0. The first is drawn at the bottom.
  struct Curve {
    std::span<const float> values;
    ImU32 color;
  };
  void plot(std::span<const Curve> curves, float height_pt, float least_top, const char* unit);
  // Bar behind the following text of this line; share of the width.
  void bar(float share, ImU32 color);

  void hint(const char* text);
  void note_control(Control::Kind kind, const char* name, bool enabled = true);

 private:
  float begin_row(const char* label);
  const char* panel_ = "";
};

}  // namespace fire3dv::gui
