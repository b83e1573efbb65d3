// Pixels of the window's screenshots, from the size that the user chooses.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string_view>

#include "base/error.h"
#include "renderer/editing/view_state.h"

namespace fire3dv::gui {

// An RGBA image of this many pixels takes 1 GiB.
constexpr uint64_t kMaxScreenshotPixels = uint64_t{1} << 28;
constexpr uint32_t kMaxScreenshotSide = 65'536;  // pixels

// text: WxH, within the limits above. The error names the text and them.
Result<glm::uvec2> parse_screenshot_size(std::string_view text);
// window_px: size of the image in the window.
Result<glm::uvec2> screenshot_px(const app::ScreenshotSize& size, glm::uvec2 window_px);

}  // namespace fire3dv::gui
