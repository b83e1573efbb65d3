// The font of panels and of text markers.
#pragma once

#include <cstddef>
#include <span>

namespace fire3dv::passes {

// TrueType data, embedded at build time.
std::span<const std::byte> font_bytes();

}  // namespace fire3dv::passes
