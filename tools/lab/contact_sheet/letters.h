// Bitmap text of 3x5 pixel letters, so that thumbnail pages need no font.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "renderer/sinks/frame.h"

namespace fire3dv::contact_sheet {

constexpr uint32_t kDot = 2;                 // pixels
constexpr uint32_t kLetterWidth = 4 * kDot;  // includes the gap
constexpr uint32_t kLineHeight = 7 * kDot;

// Draws from the top left corner, clipped to the image. Lower case is drawn as upper case, unknown characters
// as question marks.
void write_text(sinks::FrameImage& image, uint32_t x, uint32_t y, std::string_view text,
                std::array<uint8_t, 3> color);

}  // namespace fire3dv::contact_sheet
