#include "renderer/app/options/option_values.h"

#include <charconv>

namespace fire3dv::app {

bool parse_image_size(const std::string& text, uint32_t& width, uint32_t& height) {
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, width);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != 'x') return false;
  const auto second = std::from_chars(first.ptr + 1, end, height);
  return second.ec == std::errc() && second.ptr == end && width >= 1 && height >= 1 &&
         width <= kMaxImageSide && height <= kMaxImageSide;
}

}  // namespace fire3dv::app
