// Font of the panels: TrueType data, embedded at build time.
#pragma once

#include <cstddef>
#include <span>

namespace fire3dv::gui {

std::span<const std::byte> font_bytes();

}  // namespace fire3dv::gui
