#include "renderer/app/options/option_values.h"

#include <algorithm>
#include <tuple>

#include "base/numbers.h"

namespace fire3dv::app {

bool parse_image_size(const std::string& text, uint32_t& width, uint32_t& height) {
  const auto sides = parse_pair<uint32_t>(text, 'x');
  if (!sides) return false;
  std::tie(width, height) = *sides;
  return std::min(width, height) >= 1 && std::max(width, height) <= kMaxImageSide;
}

}  // namespace fire3dv::app
