// The few kinds of things that panels are made of, each with one look. All that a user can act on passes
// through here, so that a test finds it.
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

// Rows are as high as one line: what would break it becomes a blank.
std::string one_line(std::string_view text);

class Ui {
 public:
  float scale = 1;
  bool notes_controls = false;
  std::vector<Control> controls;

  void begin_frame(float display_scale);
  float points(float pt) const { return std::round(pt * scale); }

  // A panel's title, which opens and closes it. True: it is open. What follows belongs to it.
  bool header(const char* title, bool& open);
  // What follows belongs to this panel, which has no title.
  void enter(const char* panel) { panel_ = panel; }

  // A label at the left, and what it says at the right.
  void value(const char* label, const char* format, ...) IM_FMTARGS(3);
  void value(const char* label, ImU32 color, const std::string& text);
  void note(const std::string& text);  // quiet words over the whole width

  bool button(const char* label, bool enabled = true, const char* hint = nullptr, bool pressed = false);
  void same_line() { ImGui::SameLine(0, points(4)); }
  // These have the label at the left, too, and are true when the user has changed the value.
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
  // A line of a list that can be chosen.
  bool row(const char* text, bool chosen, ImU32 text_color = theme::kText, float width = 0);
  // A small sign at the end of a row.
  bool sign(const char* name, const char* glyph, ImU32 color, float width);
  // The edge between two parts of the window; returns by how many pixels it was moved.
  float edge(const char* name, bool upright, const Rect& rect);

  // Filled curves of the newest values, each against the same scale from 0. The first lies below.
  struct Curve {
    std::span<const float> values;
    ImU32 color;
  };
  void plot(std::span<const Curve> curves, float height_pt, float least_top, const char* unit);
  // A bar behind the text that follows in this line: the share of the width.
  void bar(float share, ImU32 color);

  void hint(const char* text);
  void note_control(Control::Kind kind, const char* name, bool enabled = true);

 private:
  float begin_row(const char* label);
  const char* panel_ = "";
};

}  // namespace fire3dv::gui
