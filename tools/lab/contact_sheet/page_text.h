// Text in images of the CPU: one line in the font of the panels.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer/passes/markers/true_type_font.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::contact_sheet {

class PageText {
 public:
  static constexpr uint32_t kLineHeight = 15;  // pixels

  // Draws valid UTF-8 from the top left corner. A text wider than max_width ends with that width: its start
  // becomes an ellipsis.
  void draw(sinks::FrameImage& image, uint32_t x, uint32_t y, uint32_t max_width, const std::string& text,
            const std::array<uint8_t, 3>& color);

 private:
  struct Glyph {
    float advance = 0;
    passes::TrueTypeFont::Bitmap coverage;
  };
  const Glyph& glyph(uint32_t character);

  passes::TrueTypeFont font_;
  std::map<uint32_t, Glyph> glyphs_;
};

}  // namespace fire3dv::contact_sheet
