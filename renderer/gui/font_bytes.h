// The letters of panels: a TrueType font that the build puts into the program, so that no file is looked for.
#pragma once

#include <cstddef>
#include <span>

namespace fire3dv::gui {

std::span<const std::byte> font_bytes();

}  // namespace fire3dv::gui
