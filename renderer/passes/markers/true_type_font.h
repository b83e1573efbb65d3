// Glyphs of the embedded TrueType font, as coverage or as signed distance fields.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace fire3dv::passes {

class TrueTypeFont {
 public:
  // Values from left to right, top to bottom. left, top: from the pen on the baseline, y down. Empty: a
  // space.
  struct Bitmap {
    int left = 0, top = 0, width = 0, height = 0;
    std::vector<uint8_t> values;
  };
  // Signed distance: `on_edge` at the outline, per_pixel more for each pixel inside.
  struct Field {
    int margin_px = 0;
    uint8_t on_edge = 128;
    float per_pixel = 1;
  };

  TrueTypeFont();
  ~TrueTypeFont();
  TrueTypeFont(const TrueTypeFont&) = delete;
  TrueTypeFont& operator=(const TrueTypeFont&) = delete;

  int glyph_index(uint32_t character) const;  // 0: the box of the font, for characters that it lacks
  // Sizes are in pixels, for a font of so many pixels per em.
  float ascent(float em_px) const;   // of a line, above the baseline
  float descent(float em_px) const;  // below it, positive
  float advance(int glyph, float em_px) const;
  Bitmap coverage(int glyph, float em_px) const;
  Bitmap distance_field(int glyph, float em_px, const Field& field) const;

 private:
  struct Face;
  std::unique_ptr<Face> face_;
};

}  // namespace fire3dv::passes
