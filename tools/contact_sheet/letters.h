// Writing on images: letters of three by five dots, so that pages of thumbnails need no font.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "renderer/sinks/frame.h"

namespace fire3dv::contact_sheet {

constexpr uint32_t kDot = 2;                 // pixels
constexpr uint32_t kLetterWidth = 4 * kDot;  // with the gap to the next one
constexpr uint32_t kLineHeight = 7 * kDot;

// From the upper left corner on; what would lie outside is left out. Small letters are drawn as capitals,
// what has no letter here as a question mark.
void write_text(sinks::FrameImage& image, uint32_t x, uint32_t y, std::string_view text,
                std::array<uint8_t, 3> color);

}  // namespace fire3dv::contact_sheet
