// Glyph atlas of text markers: signed distance fields of the embedded font's glyphs, made when they are first
// used. One field serves all sizes. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <vector>

#include "renderer/passes/markers/true_type_font.h"
#include "shaders/shared/glyph_types.h"

namespace fire3dv::passes {

class GlyphAtlas {
 public:
  static constexpr uint32_t kWidth = FIRE3DV_GLYPH_ATLAS_WIDTH;

  // Lengths are in units of the font size (em), y up, from the pen's position on the baseline.
  struct Glyph {
    glm::vec2 low{0}, high{0};  // rectangle, with the field's margin
    glm::vec4 texels{0};        // of low and high in the atlas
    float advance = 0;          // to the next pen position
    bool is_visible = false;    // false: a space
  };

  GlyphAtlas();
  GlyphAtlas(const GlyphAtlas&) = delete;
  GlyphAtlas& operator=(const GlyphAtlas&) = delete;

  // The box of the font for a character that it lacks, and once the atlas has kMaxGlyphs, for one that is
  // new. ASCII is always there. Valid until the atlas is destroyed.
  const Glyph& glyph(uint32_t character);
  float ascent() const { return ascent_; }    // of a line, above the baseline
  float descent() const { return descent_; }  // below the baseline, positive

  std::span<const uint8_t> texels() const { return texels_; }  // kWidth by rows()
  uint32_t rows() const { return static_cast<uint32_t>(texels_.size() / kWidth); }
  uint64_t revision() const { return revision_; }  // changes with the texels

  static constexpr size_t kMaxGlyphs = 1024;

 private:
  const Glyph& add(int index);

  TrueTypeFont font_;
  std::map<int, Glyph> glyphs_;  // by index in the font; 0: its box
  std::vector<uint8_t> texels_;
  uint32_t x_ = 1, y_ = 1, row_height_ = 0;  // position of the next glyph
  float ascent_ = 0, descent_ = 0;
  uint64_t revision_ = 0;
};

}  // namespace fire3dv::passes
