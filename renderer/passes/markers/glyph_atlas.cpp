#include "renderer/passes/markers/glyph_atlas.h"

#include <algorithm>

#include "base/error.h"

namespace fire3dv::passes {
namespace {

constexpr float kTexelsPerEm = 40;
constexpr int kMargin = 5;  // texels of the field around a glyph
static_assert(static_cast<float>(kMargin) * FIRE3DV_GLYPH_VALUES_PER_TEXEL >= FIRE3DV_GLYPH_ON_EDGE);

}  // namespace

GlyphAtlas::GlyphAtlas() : ascent_(font_.ascent(1)), descent_(font_.descent(1)) {
  add(0);
  // So that no text makes those of others illegible.
  for (uint32_t character = 0x20; character < 0x7f; ++character) (void)glyph(character);
}

const GlyphAtlas::Glyph& GlyphAtlas::glyph(uint32_t character) {
  const int index = font_.glyph_index(character);
  if (const auto known = glyphs_.find(index); known != glyphs_.end()) return known->second;
  return glyphs_.size() < kMaxGlyphs ? add(index) : glyphs_.at(0);
}

const GlyphAtlas::Glyph& GlyphAtlas::add(int index) {
  Glyph& glyph = glyphs_[index];
  glyph.advance = font_.advance(index, kTexelsPerEm) / kTexelsPerEm;
  const TrueTypeFont::Bitmap field = font_.distance_field(
      index, kTexelsPerEm,
      {kMargin, static_cast<uint8_t>(FIRE3DV_GLYPH_ON_EDGE), FIRE3DV_GLYPH_VALUES_PER_TEXEL});
  if (field.values.empty()) return glyph;
  const auto columns = static_cast<uint32_t>(field.width), lines = static_cast<uint32_t>(field.height);
  FIRE3DV_ASSERT(columns + 2 <= kWidth);
  if (x_ + columns + 1 > kWidth) {
    x_ = 1;
    y_ += row_height_ + 1;
    row_height_ = 0;
  }
  row_height_ = std::max(row_height_, lines);
  texels_.resize(std::max(texels_.size(), size_t{y_ + lines + 1} * kWidth));  // an empty row below
  for (uint32_t line = 0; line < lines; ++line)
    std::copy_n(field.values.begin() + line * columns, columns, texels_.begin() + (y_ + line) * kWidth + x_);
  // The field's rows run downwards.
  glyph.low = glm::vec2(field.left, -(field.top + field.height)) / kTexelsPerEm;
  glyph.high = glm::vec2(field.left + field.width, -field.top) / kTexelsPerEm;
  glyph.texels = glm::vec4(x_, y_ + lines, x_ + columns, y_);
  glyph.is_visible = true;
  x_ += columns + 1;
  ++revision_;
  return glyph;
}

}  // namespace fire3dv::passes
