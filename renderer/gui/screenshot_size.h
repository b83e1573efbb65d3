// Size of the window's screenshots, as the user chooses it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <string_view>

#include "base/error.h"

namespace fire3dv::gui {

// An RGBA image of this many pixels takes 1 GiB.
constexpr uint64_t kMaxScreenshotPixels = uint64_t{1} << 28;
constexpr uint32_t kMaxScreenshotSide = 65'536;  // pixels

struct ScreenshotSize {
  enum class Kind : uint8_t {
    window,
    twice,
    four_times,
    fixed
  };  // the first three: of the image in the window
  Kind kind = Kind::window;
  std::string fixed_px = "3840x2160";  // WxH
  bool operator==(const ScreenshotSize&) const = default;
};

// text: WxH, within the limits above. The error names the text and them.
Result<glm::uvec2> parse_screenshot_size(std::string_view text);
// window_px: size of the image in the window.
Result<glm::uvec2> screenshot_px(const ScreenshotSize& size, glm::uvec2 window_px);

}  // namespace fire3dv::gui
