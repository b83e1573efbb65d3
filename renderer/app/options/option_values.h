// Parser of image sizes on command lines.
#pragma once

#include <cstdint>
#include <string>

namespace fire3dv::app {

constexpr uint32_t kMaxImageSide = 16384;  // pixels

// text: WxH with sides of 1 to kMaxImageSide; returns false for anything else.
bool parse_image_size(const std::string& text, uint32_t& width, uint32_t& height);

}  // namespace fire3dv::app
