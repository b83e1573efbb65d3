// Version of the renderer, set by CMake.
#pragma once

namespace fire3dv::app {
inline constexpr const char* kVersion = FIRE3DV_VERSION;
}
