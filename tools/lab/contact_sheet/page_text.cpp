#include "tools/lab/contact_sheet/page_text.h"

#include <cmath>
#include <numeric>

#include "base/text.h"

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

const PageText::Glyph& PageText::glyph(uint32_t character) {
  const auto [entry, is_new] = glyphs_.try_emplace(character);
  Glyph& glyph = entry->second;
  if (!is_new) return glyph;
  const int index = font_.glyph_index(character);
  glyph.advance = font_.advance(index, kTextPx);
  glyph.coverage = font_.coverage(index, kTextPx);
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
  const int baseline = static_cast<int>(std::lround(static_cast<float>(y) + font_.ascent(kTextPx)));
  for (const uint32_t character : characters) {
    const Glyph& drawn = glyph(character);
    const passes::TrueTypeFont::Bitmap& shown = drawn.coverage;
    for (int i = 0; i < shown.width * shown.height; ++i) {
      const int64_t column = std::lround(pen) + shown.left + i % shown.width;
      const int64_t row = int64_t{baseline} + shown.top + i / shown.width;
      const bool is_inside = column >= x && column < int64_t{x} + max_width && column < image.width &&
                             row >= 0 && row < image.height;
      if (!is_inside) continue;
      uint8_t* const pixel =
          &image.rgba8[4 * (static_cast<size_t>(row) * image.width + static_cast<size_t>(column))];
      const int share = shown.values[static_cast<size_t>(i)];
      for (size_t channel = 0; channel < 3; ++channel)
        pixel[channel] =
            static_cast<uint8_t>((pixel[channel] * (255 - share) + color[channel] * share) / 255);
    }
    pen += drawn.advance;
  }
}

}  // namespace fire3dv::contact_sheet
