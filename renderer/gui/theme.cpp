// Theme and fonts of the panels.

#include <cmath>

#include "renderer/gui/widgets.h"
#include "renderer/passes/markers/font.h"

namespace fire3dv::gui {
namespace {

constexpr float kTextPt = 13;

}  // namespace

void apply_theme(float scale, bool is_light) {
  theme::palette = is_light ? &theme::kLight : &theme::kDark;
  const theme::Palette& palette = *theme::palette;
  ImGuiStyle style;
  style.WindowPadding = {10, 8};
  style.FramePadding = {6, 3};
  style.ItemSpacing = {6, 4};
  style.ItemInnerSpacing = {5, 4};
  style.CellPadding = {4, 2};
  style.IndentSpacing = 12;
  style.ScrollbarSize = 10;
  style.GrabMinSize = 8;
  style.WindowRounding = 0;
  style.ChildRounding = style.FrameRounding = style.PopupRounding = style.GrabRounding = 3;
  style.ScrollbarRounding = 5;
  style.WindowBorderSize = 0;
  style.ChildBorderSize = 0;
  style.PopupBorderSize = 1;
  style.FrameBorderSize = 0;
  style.ScaleAllSizes(scale);
  style.WindowMinSize = {1, 1};  // columns may be arbitrarily narrow
  style.DisabledAlpha = 0.4f;

  ImVec4* const colors = style.Colors;
  for (int i = 0; i < ImGuiCol_COUNT; ++i) colors[i] = theme::floats(theme::palette->well);
  colors[ImGuiCol_Text] = theme::floats(theme::palette->text);
  colors[ImGuiCol_TextDisabled] = theme::floats(theme::palette->dim);
  colors[ImGuiCol_WindowBg] = theme::floats(theme::palette->panel);
  colors[ImGuiCol_ChildBg] = theme::floats(theme::palette->panel);
  colors[ImGuiCol_PopupBg] = theme::floats(theme::palette->panel);
  colors[ImGuiCol_Border] = theme::floats(palette.border);
  colors[ImGuiCol_BorderShadow] = {0, 0, 0, 0};
  colors[ImGuiCol_FrameBgHovered] = colors[ImGuiCol_FrameBgActive] =
      theme::floats(theme::palette->well_hovered);
  colors[ImGuiCol_ScrollbarBg] = {0, 0, 0, 0};
  colors[ImGuiCol_ScrollbarGrab] = theme::floats(palette.grab);
  colors[ImGuiCol_ScrollbarGrabHovered] = colors[ImGuiCol_ScrollbarGrabActive] =
      theme::floats(palette.grab_hovered);
  colors[ImGuiCol_CheckMark] = colors[ImGuiCol_SliderGrab] = theme::floats(theme::palette->accent);
  colors[ImGuiCol_SliderGrabActive] = theme::floats(palette.slider_active);
  colors[ImGuiCol_Button] = theme::floats(palette.button);
  colors[ImGuiCol_ButtonHovered] = theme::floats(palette.button_hovered);
  colors[ImGuiCol_ButtonActive] = theme::floats(theme::palette->accent_dark);
  colors[ImGuiCol_Header] = theme::floats(theme::palette->accent_dark);
  colors[ImGuiCol_HeaderHovered] = theme::floats(theme::palette->well_hovered);
  colors[ImGuiCol_HeaderActive] = theme::floats(theme::palette->accent_dark);
  colors[ImGuiCol_Separator] = theme::floats(theme::palette->line);
  colors[ImGuiCol_PlotLines] = theme::floats(theme::palette->accent);
  colors[ImGuiCol_TextSelectedBg] = theme::floats(theme::palette->accent_dark);
  colors[ImGuiCol_NavHighlight] = {0, 0, 0, 0};
  ImGui::GetStyle() = style;
}

void make_fonts(ImFontAtlas& fonts, float scale) {
  static constexpr ImWchar kRanges[] = {0x0020, 0x024f,                  // Latin
                                        0x0370, 0x03ff, 0x0400, 0x045f,  // Greek, Cyrillic
                                        0x2010, 0x2026,                  // dashes, quotes, dots
                                        0x2190, 0x2193, 0x2248, 0x2265,  // arrows; almost equal, <=, >=
                                        0x25a0, 0x25cf,                  // shapes: play, stop, visible
                                        0xfffd, 0xfffd, 0};
  fonts.Clear();
  fonts.Flags |= ImFontAtlasFlags_NoMouseCursors;
  ImFontConfig config;
  config.FontDataOwnedByAtlas = false;
  config.OversampleH = 2;
  config.OversampleV = 1;
  config.PixelSnapH = true;
  const auto bytes = passes::font_bytes();
  // ImGui's parameter is not const, but data that it does not own is not modified.
  fonts.AddFontFromMemoryTTF(const_cast<std::byte*>(bytes.data()), static_cast<int>(bytes.size()),
                             std::round(kTextPt * scale), &config, kRanges);
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  fonts.GetTexDataAsAlpha8(&pixels, &width, &height);
}

}  // namespace fire3dv::gui
