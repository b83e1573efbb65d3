// Test of the themes: contrast of texts by the formula of WCAG 2, and panels that take the other palette at
// once.
#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "renderer/gui/layout_file.h"
#include "renderer/gui/widgets.h"
#include "tests/unit/renderer/gui/gui_world.h"

namespace fire3dv::test {
namespace {

using gui::theme::Palette;

// Relative luminance of an sRGB colour.
double luminance(ImU32 color) {
  const auto linear = [&](int shift) {
    const double c = (color >> shift & 0xff) / 255.0;
    return c <= 0.03928 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(IM_COL32_R_SHIFT) + 0.7152 * linear(IM_COL32_G_SHIFT) +
         0.0722 * linear(IM_COL32_B_SHIFT);
}
double contrast(ImU32 a, ImU32 b) {
  const auto [low, high] = std::minmax({luminance(a), luminance(b)});
  return (high + 0.05) / (low + 0.05);
}

TEST(GuiTheme, TextsCanBeRead) {
  for (const Palette* palette : {&gui::theme::kDark, &gui::theme::kLight}) {
    const Palette& p = *palette;
    for (const ImU32 ground :
         {p.panel, p.well, p.well_hovered, p.button, p.button_hovered, p.accent_dark, p.bar})
      EXPECT_GE(contrast(p.text, ground), 4.5);
    for (const ImU32 text : {p.dim, p.accent, p.good, p.warning, p.bad, p.second})
      EXPECT_GE(contrast(text, p.panel), 4.5) << std::hex << text;
    for (const ImU32 curve : p.curves) EXPECT_GE(contrast(curve, p.panel), 3);
  }
  EXPECT_GT(luminance(gui::theme::kLight.panel), 0.8);
  EXPECT_LT(luminance(gui::theme::kDark.panel), 0.05);
}

// Colours of the panels' large areas.
std::set<ImU32> colors(const ImDrawData& data) {
  std::set<ImU32> found;
  for (int l = 0; l < data.CmdListsCount; ++l) {
    for (const ImDrawVert& vertex : data.CmdLists[l]->VtxBuffer) found.insert(vertex.col);
  }
  return found;
}

TEST(GuiTheme, PaletteSwitchesImmediately) {
  GuiWorld world;
  for (const bool is_light : {false, true, false}) {
    gui::Layout layout;
    layout.is_light = is_light;
    gui::Gui panels(layout);
    gui::Input input;
    input.display_px = {1280, 720};
    const gui::Shown shown{world.scene, world.poses};
    for (int i = 0; i < 2; ++i) panels.frame(input, world.facts, shown, world.view_state);
    const std::set<ImU32> now = colors(panels.frame(input, world.facts, shown, world.view_state));
    EXPECT_EQ(now.contains(gui::theme::kLight.panel), is_light);
    EXPECT_EQ(now.contains(gui::theme::kDark.panel), !is_light);
    EXPECT_EQ(now.contains(gui::theme::kDark.text), !is_light) << "a text kept the other theme";
  }
}

}  // namespace
}  // namespace fire3dv::test
