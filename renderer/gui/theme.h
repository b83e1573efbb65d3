// Theme of the panels: dark, with one accent colour.
#pragma once

#include <imgui.h>

#include <cstdint>

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
}  // namespace theme

// Applies the theme to the current context at this display scale.
void apply_theme(float scale);
// Builds the font atlas: Latin, Greek, Cyrillic, and the symbols that panels use.
void make_fonts(ImFontAtlas& fonts, float scale);

}  // namespace fire3dv::gui
