#include "tools/lab/contact_sheet/page_text.h"

#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/text.h"
#include "renderer/passes/markers/font.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#include <stb/stb_truetype.h>
#pragma GCC diagnostic pop

namespace fire3dv::contact_sheet {
namespace {

constexpr float kTextPx = 12;
constexpr uint32_t kEllipsis = 0x2026;

std::vector<uint32_t> characters_of(const std::string& text) {
  std::vector<uint32_t> characters;
  for (size_t at = 0; at < text.size();) characters.push_back(next_character(text, at));
  return characters;
}

}  // namespace

PageText::PageText() : font_(std::make_unique<stbtt_fontinfo>()) {
  const auto* const bytes = reinterpret_cast<const unsigned char*>(passes::font_bytes().data());
  const int is_read = stbtt_InitFont(font_.get(), bytes, stbtt_GetFontOffsetForIndex(bytes, 0));
  FIRE3DV_ASSERT(is_read != 0);
  scale_ = stbtt_ScaleForMappingEmToPixels(font_.get(), kTextPx);
  int ascent = 0, descent = 0, gap = 0;
  stbtt_GetFontVMetrics(font_.get(), &ascent, &descent, &gap);
  ascent_ = scale_ * static_cast<float>(ascent);
}

PageText::~PageText() = default;

const PageText::Glyph& PageText::glyph(uint32_t character) {
  const auto [entry, is_new] = glyphs_.try_emplace(character);
  Glyph& glyph = entry->second;
  if (!is_new) return glyph;
  const int index = stbtt_FindGlyphIndex(font_.get(), static_cast<int>(character));
  int advance = 0, bearing = 0;
  stbtt_GetGlyphHMetrics(font_.get(), index, &advance, &bearing);
  glyph.advance = scale_ * static_cast<float>(advance);
  unsigned char* const pixels = stbtt_GetGlyphBitmap(font_.get(), scale_, scale_, index, &glyph.width,
                                                     &glyph.height, &glyph.left, &glyph.top);
  if (pixels) glyph.coverage.assign(pixels, pixels + glyph.width * glyph.height);
  stbtt_FreeBitmap(pixels, nullptr);
  return glyph;
}

void PageText::draw(sinks::FrameImage& image, uint32_t x, uint32_t y, uint32_t max_width,
                    const std::string& text, const std::array<uint8_t, 3>& color) {
  std::vector<uint32_t> characters = characters_of(text);
  const auto width_of = [this](const std::vector<uint32_t>& of) {
    return std::accumulate(of.begin(), of.end(), 0.0f,
                           [this](float sum, uint32_t each) { return sum + glyph(each).advance; });
  };
  const auto limit = static_cast<float>(max_width);
  for (bool is_cut = false; characters.size() > 1 && width_of(characters) > limit; is_cut = true) {
    characters.erase(characters.begin() + (is_cut ? 1 : 0));
    characters.front() = kEllipsis;
  }
  float pen = static_cast<float>(x);
  const int baseline = static_cast<int>(std::lround(static_cast<float>(y) + ascent_));
  for (const uint32_t character : characters) {
    const Glyph& shown = glyph(character);
    for (int i = 0; i < shown.width * shown.height; ++i) {
      const int64_t column = std::lround(pen) + shown.left + i % shown.width;
      const int64_t row = int64_t{baseline} + shown.top + i / shown.width;
      const bool is_inside = column >= x && column < int64_t{x} + max_width && column < image.width &&
                             row >= 0 && row < image.height;
      if (!is_inside) continue;
      uint8_t* const pixel =
          &image.rgba8[4 * (static_cast<size_t>(row) * image.width + static_cast<size_t>(column))];
      const int share = shown.coverage[static_cast<size_t>(i)];
      for (size_t channel = 0; channel < 3; ++channel)
        pixel[channel] =
            static_cast<uint8_t>((pixel[channel] * (255 - share) + color[channel] * share) / 255);
    }
    pen += shown.advance;
  }
}

}  // namespace fire3dv::contact_sheet
