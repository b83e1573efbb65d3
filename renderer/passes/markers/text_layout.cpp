#include "renderer/passes/markers/text_layout.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/text.h"

namespace fire3dv::passes {
namespace {

// Adds the glyphs of one line, whose baseline is at this height over the position.
void add_line(std::string_view line, float baseline, GlyphAtlas& atlas, TextGlyphs& to) {
  float width = 0;
  for (size_t at = 0; at < line.size();) width += atlas.glyph(next_character(line, at)).advance;
  float pen = -0.5f * width;
  for (size_t at = 0; at < line.size();) {
    const GlyphAtlas::Glyph& glyph = atlas.glyph(next_character(line, at));
    const glm::vec2 low = glyph.low + glm::vec2(pen, baseline), high = glyph.high + glm::vec2(pen, baseline);
    pen += glyph.advance;
    if (!glyph.is_visible) continue;
    to.rectangles.push_back({low.x, low.y, high.x, high.y});
    to.rectangles.push_back({glyph.texels.x, glyph.texels.y, glyph.texels.z, glyph.texels.w});
    for (const float side : {low.x, low.y, high.x, high.y}) to.reach = std::max(to.reach, std::abs(side));
  }
}

}  // namespace

TextGlyphs lay_out(const wire::Marker& texts, GlyphAtlas& atlas) {
  TextGlyphs glyphs;
  const float line_height = atlas.ascent() + atlas.descent();
  for (size_t i = 0; i < texts.texts.size(); ++i) {
    std::string_view text = texts.texts[i];
    const auto lines = 1 + std::ranges::count(text, '\n');
    float baseline = 0.5f * static_cast<float>(lines) * line_height - atlas.ascent();
    while (true) {
      const size_t end = text.find('\n');
      add_line(text.substr(0, end), baseline, atlas, glyphs);
      if (end == text.npos) break;
      text.remove_prefix(end + 1);
      baseline -= line_height;
    }
    glyphs.positions.resize(glyphs.rectangles.size() / 2, texts.positions[i]);
    if (texts.colors.size() > 1) glyphs.colors.resize(glyphs.positions.size(), texts.colors[i]);
  }
  if (texts.colors.size() == 1) glyphs.colors = texts.colors;
  return glyphs;
}

}  // namespace fire3dv::passes
