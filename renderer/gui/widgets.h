// Widget set and theme of the panels: a uniform style, dark or light, with one accent colour. All interactive
// controls are created here, so that tests can find them.
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
struct Palette {
  ImU32 accent, accent_dark;  // of text and lines; of chosen rows and buttons
  ImU32 text, dim, faint;
  ImU32 panel, well, well_hovered, line, border;
  ImU32 grab, grab_hovered, slider_active, button, button_hovered, bar;
  // Status colours, next to a word of the same meaning.
  ImU32 good, warning, bad, second;
  ImU32 curves[3];  // of plots, beside the above
};
inline constexpr Palette kDark{rgb(0x4aa3df), rgb(0x2b5876), rgb(0xdde1e6),
                               rgb(0x8b939d), rgb(0x5a626c), rgb(0x17191d),
                               rgb(0x22262c), rgb(0x2b3038), rgb(0x2a2f36),
                               rgb(0x3a414a), rgb(0x333942), rgb(0x454d58),
                               rgb(0x7cc0ee), rgb(0x2a2f37), rgb(0x39414c),
                               rgb(0x24303b), rgb(0x6cc070), rgb(0xe6b450),
                               rgb(0xe0645c), rgb(0xb48ce0), {rgb(0x5fd0c5), rgb(0xf08fc0), rgb(0xc9c9c9)}};
inline constexpr Palette kLight{rgb(0x1769a6), rgb(0xb5d7ef), rgb(0x1c2126),
                                rgb(0x59626c), rgb(0x9098a1), rgb(0xf4f5f7),
                                rgb(0xe4e7eb), rgb(0xd6dbe1), rgb(0xd5d9de),
                                rgb(0xb9c0c8), rgb(0xc3c9d0), rgb(0xa9b1ba),
                                rgb(0x0f4f80), rgb(0xdce1e6), rgb(0xc9d1d9),
                                rgb(0xcfe2f0), rgb(0x2e7d32), rgb(0x8f5f00),
                                rgb(0xb3261e), rgb(0x7445a8), {rgb(0x0b7a70), rgb(0xb0317c), rgb(0x5c5c5c)}};
// The palette of the current theme; set by apply_theme().
inline const Palette* palette = &kDark;
inline ImVec4 floats(ImU32 color) {
  return ImGui::ColorConvertU32ToFloat4(color);
}
}  // namespace theme

// Applies the light or dark theme to the current context at this display scale.
void apply_theme(float scale, bool is_light);
// Builds the font atlas: Latin, Greek, Cyrillic, and the symbols that panels use.
void make_fonts(ImFontAtlas& fonts, float scale);

// ImGui rejects buttons without an area, and windows may be as small as a pixel.
bool invisible_button(const char* name, float width_px, float height_px);
// Shortens a text of one line to this width in pixels, with an ellipsis at its end.
std::string elided(const std::string& text, float width_px);
// Breaks a text of one line at spaces, so that lines have this width in pixels where words do: ImGui would
// break numbers after their point.
std::string wrapped(std::string text, float width_px);
// 0 in place of a number that its format would show as -0.0.
float without_minus_zero(float value, const char* format);
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
  // Widgets between these two cannot be used if it is true. Not nested.
  void begin_disabled(bool disabled);
  void end_disabled();
  // Three numbers in a row: drag to change, Ctrl-click to type. step: change for a pixel of a drag.
  struct Numbers {
    float step;
    const char* format;
  };
  bool numbers(const char* label, glm::vec3& value, const Numbers& numbers, const char* hint = nullptr);
  bool choice(const char* label, size_t& chosen, std::span<const char* const> names,
              const char* hint = nullptr);
  bool has_opened_list() const { return has_opened_list_; }  // by the last choice(), in this frame
  bool color(const char* label, glm::vec3& linear, const char* hint = nullptr);
  bool text(const char* name, const char* hint, std::string& value);
  // Selectable list row.
  bool row(const char* text, bool chosen, ImU32 text_color = theme::palette->text, float width = 0);
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
  bool wants_same_line_ = false, is_disabled_ = false, has_opened_list_ = false;
  const char* panel_ = "";
};

}  // namespace fire3dv::gui
