// Parsers of option values on command lines: image sizes, numbers and colours; texts of their help.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace fire3dv::passes {
struct Background;
}

namespace fire3dv::app {

constexpr uint32_t kMaxImageSide = 16384;  // pixels

// text: WxH with sides of 1 to kMaxImageSide; returns false for anything else.
bool parse_image_size(const std::string& text, uint32_t& width, uint32_t& height);

// Checks of CLI11 options: return an error message, or an empty text. CLI11's own checks accept NaN and
// infinity.
std::string positive_number(const std::string& text);
std::string number_from_zero(const std::string& text);
std::string finite_number(const std::string& text);
std::string share_number(const std::string& text);      // 0 to 1
std::string f_number(const std::string& text);          // 0.1 to 1000
std::string focus_distance_m(const std::string& text);  // 0.001 to 1000000
std::string anisotropy_number(const std::string& text);

// "label a, b or c"
std::string names_text(std::string label, const std::vector<std::string>& names);

// Parses "environment" or an sRGB colour.
bool parse_background(std::string_view text, passes::Background& background);

}  // namespace fire3dv::app
