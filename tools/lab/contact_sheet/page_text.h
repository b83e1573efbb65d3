// Text in images of the CPU: one line in the font of the panels.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "renderer/sinks/frame.h"

struct stbtt_fontinfo;

namespace fire3dv::contact_sheet {

class PageText {
 public:
  static constexpr uint32_t kLineHeight = 15;  // pixels

  PageText();
  ~PageText();
  PageText(const PageText&) = delete;
  PageText& operator=(const PageText&) = delete;

  // Draws valid UTF-8 from the top left corner. A text wider than max_width ends with that width: its start
  // becomes an ellipsis.
  void draw(sinks::FrameImage& image, uint32_t x, uint32_t y, uint32_t max_width, const std::string& text,
            const std::array<uint8_t, 3>& color);

 private:
  struct Glyph {
    int left = 0, top = 0, width = 0, height = 0;  // of the coverage, from the pen on the baseline
    float advance = 0;
    std::vector<uint8_t> coverage;
  };
  const Glyph& glyph(uint32_t character);

  std::unique_ptr<stbtt_fontinfo> font_;
  float scale_ = 1, ascent_ = 0;
  std::map<uint32_t, Glyph> glyphs_;
};

}  // namespace fire3dv::contact_sheet
