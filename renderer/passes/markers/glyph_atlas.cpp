#include "renderer/passes/markers/glyph_atlas.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "renderer/passes/markers/font.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#include <stb/stb_truetype.h>
#pragma GCC diagnostic pop

namespace fire3dv::passes {
namespace {

constexpr float kTexelsPerEm = 40;
constexpr int kMargin = 5;  // texels of the field around a glyph
static_assert(static_cast<float>(kMargin) * FIRE3DV_GLYPH_VALUES_PER_TEXEL >= FIRE3DV_GLYPH_ON_EDGE);

}  // namespace

GlyphAtlas::GlyphAtlas() : font_(std::make_unique<stbtt_fontinfo>()) {
  const auto* const bytes = reinterpret_cast<const unsigned char*>(font_bytes().data());
  const int is_read = stbtt_InitFont(font_.get(), bytes, stbtt_GetFontOffsetForIndex(bytes, 0));
  FIRE3DV_ASSERT(is_read != 0);
  const float scale = stbtt_ScaleForMappingEmToPixels(font_.get(), 1);
  int ascent = 0, descent = 0, gap = 0;
  stbtt_GetFontVMetrics(font_.get(), &ascent, &descent, &gap);
  ascent_ = scale * static_cast<float>(ascent);
  descent_ = -scale * static_cast<float>(descent);
  add(0);
  // So that no text makes those of others illegible.
  for (uint32_t character = 0x20; character < 0x7f; ++character) (void)glyph(character);
}

GlyphAtlas::~GlyphAtlas() = default;

const GlyphAtlas::Glyph& GlyphAtlas::glyph(uint32_t character) {
  const int index = stbtt_FindGlyphIndex(font_.get(), static_cast<int>(character));
  if (const auto known = glyphs_.find(index); known != glyphs_.end()) return known->second;
  return glyphs_.size() < kMaxGlyphs ? add(index) : glyphs_.at(0);
}

const GlyphAtlas::Glyph& GlyphAtlas::add(int index) {
  Glyph& glyph = glyphs_[index];
  const float scale = stbtt_ScaleForMappingEmToPixels(font_.get(), kTexelsPerEm);
  int advance = 0, bearing = 0;
  stbtt_GetGlyphHMetrics(font_.get(), index, &advance, &bearing);
  glyph.advance = scale * static_cast<float>(advance) / kTexelsPerEm;
  int width = 0, height = 0, left = 0, top = 0;
  unsigned char* const field =
      stbtt_GetGlyphSDF(font_.get(), scale, index, kMargin, static_cast<unsigned char>(FIRE3DV_GLYPH_ON_EDGE),
                        FIRE3DV_GLYPH_VALUES_PER_TEXEL, &width, &height, &left, &top);
  if (!field) return glyph;
  const auto columns = static_cast<uint32_t>(width), lines = static_cast<uint32_t>(height);
  FIRE3DV_ASSERT(columns + 2 <= kWidth);
  if (x_ + columns + 1 > kWidth) {
    x_ = 1;
    y_ += row_height_ + 1;
    row_height_ = 0;
  }
  row_height_ = std::max(row_height_, lines);
  texels_.resize(std::max(texels_.size(), size_t{y_ + lines + 1} * kWidth));  // an empty row below
  for (uint32_t line = 0; line < lines; ++line)
    std::copy_n(field + line * columns, columns, texels_.begin() + (y_ + line) * kWidth + x_);
  stbtt_FreeSDF(field, nullptr);
  // The field's rows run downwards.
  glyph.low = glm::vec2(left, -(top + height)) / kTexelsPerEm;
  glyph.high = glm::vec2(left + width, -top) / kTexelsPerEm;
  glyph.texels = glm::vec4(x_, y_ + lines, x_ + columns, y_);
  glyph.is_visible = true;
  x_ += columns + 1;
  ++revision_;
  return glyph;
}

}  // namespace fire3dv::passes
