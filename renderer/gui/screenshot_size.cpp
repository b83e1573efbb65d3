#include "renderer/gui/screenshot_size.h"

#include "base/numbers.h"

namespace fire3dv::gui {
namespace {

std::string text_of(glm::uvec2 size) {
  return std::to_string(size.x) + "x" + std::to_string(size.y);
}

bool is_valid(glm::u64vec2 size) {
  return size.x >= 1 && size.y >= 1 && size.x <= kMaxScreenshotSide && size.y <= kMaxScreenshotSide &&
         size.x * size.y <= kMaxScreenshotPixels;
}

std::string limits() {
  return "sides of 1 to " + std::to_string(kMaxScreenshotSide) + " pixels, and at most " +
         std::to_string(kMaxScreenshotPixels >> 20) + " Mi pixels together";
}

}  // namespace

Result<glm::uvec2> parse_screenshot_size(std::string_view text) {
  const auto sides = parse_pair<uint32_t>(text, 'x');
  if (const glm::uvec2 size = sides ? glm::uvec2(sides->first, sides->second) : glm::uvec2(0); is_valid(size))
    return size;
  return Error{"\"" + std::string(text) +
               "\" is not a size of a screenshot: write WxH, such as 7680x4320, with " + limits()};
}

Result<glm::uvec2> screenshot_px(const app::ScreenshotSize& size, glm::uvec2 window_px) {
  if (size.kind == app::ScreenshotSize::Kind::fixed) return parse_screenshot_size(size.fixed_px);
  const uint64_t factor = size.kind == app::ScreenshotSize::Kind::window  ? 1
                          : size.kind == app::ScreenshotSize::Kind::twice ? 2
                                                                          : 4;
  const glm::u64vec2 wanted = factor * glm::u64vec2(window_px);
  if (factor == 1 || is_valid(wanted)) return glm::uvec2(wanted);
  return Error{"a screenshot of " + std::to_string(factor) + " times " + text_of(window_px) +
               " is too large: it may have " + limits()};
}

}  // namespace fire3dv::gui
