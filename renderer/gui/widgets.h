// Widget set and theme of the panels: a uniform style, dark with one accent colour. All interactive controls
// are created here, so that tests can find them.
#pragma once

#include <imgui.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/gui/gui.h"

namespace fire3dv::gui {

namespace theme {
constexpr ImU32 rgb(uint32_t hex, uint32_t alpha = 255) {
  return IM_COL32(hex >> 16 & 0xff, hex >> 8 & 0xff, hex & 0xff, alpha);
}
constexpr ImU32 kAccent = rgb(0x4aa3df), kAccentDark = rgb(0x2b5876);
constexpr ImU32 kText = rgb(0xdde1e6), kDim = rgb(0x8b939d), kFaint = rgb(0x5a626c);
constexpr ImU32 kPanel = rgb(0x17191d), kWell = rgb(0x22262c), kWellHovered = rgb(0x2b3038),
                kLine = rgb(0x2a2f36);
// Status colours, next to a word of the same meaning.
constexpr ImU32 kGood = rgb(0x6cc070), kWarning = rgb(0xe6b450), kBad = rgb(0xe0645c),
                kSecond = rgb(0xb48ce0);
inline ImVec4 floats(ImU32 color) {
  return ImGui::ColorConvertU32ToFloat4(color);
}
}  // namespace theme

// Applies the theme to the current context at this display scale.
void apply_theme(float scale);
// Builds the font atlas: Latin, Greek, Cyrillic, and the symbols that panels use.
void make_fonts(ImFontAtlas& fonts, float scale);

// ImGui rejects buttons without an area, and windows may be as small as a pixel.
bool invisible_button(const char* name, float width_px, float height_px);
// Shortens a text of one line to this width in pixels, with an ellipsis at its end.
std::string elided(const std::string& text, float width_px);
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
  // Puts the next button, or what flow() announces, on the same line if it fits there.
  void same_line() { wants_same_line_ = true; }
  void flow(float width_px);
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
  // Draggable splitter with a handle that folds its dock. A folded one is a handle only. arrow: points away
  // from the image, where the dock folds to.
  struct Splitter {
    const char *name, *fold, *unfold;
    ImGuiDir arrow;
  };
  struct SplitterUse {
    float moved_px = 0;
    bool toggled = false;
  };
  SplitterUse splitter(const Splitter& at_edge, const Rect& rect, bool folded);

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
  // Dimmed label, elided to this width.
  void dim_label(const char* text, float width_px);
  float edge(const char* name, bool upright, const Rect& rect);  // returns its movement in pixels
  bool handle(const Splitter& at_edge, const Rect& rect, bool folded);
  bool wants_same_line_ = false;
  const char* panel_ = "";
};

}  // namespace fire3dv::gui
