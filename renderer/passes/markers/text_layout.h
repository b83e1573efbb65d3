// Layout of text markers: one element per visible glyph, in the arrays that the marker shader reads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "protocol/wire/marker.h"
#include "renderer/passes/markers/glyph_atlas.h"

namespace fire3dv::passes {

struct TextGlyphs {
  std::vector<std::array<float, 3>> positions;   // of its text, for each glyph
  std::vector<std::array<float, 4>> rectangles;  // two per glyph (shaders/shared/glyph_types.h)
  std::vector<uint32_t> colors;                  // none, one for all, or one per glyph
  float reach = 0;  // of the rectangles from the position, in units of the font size
};

// Characters run left to right, one glyph each: neither ligatures nor combined accents. Lines are centred on
// the position.
TextGlyphs lay_out(const wire::Marker& texts, GlyphAtlas& atlas);

}  // namespace fire3dv::passes
