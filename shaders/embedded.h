// Compiled shaders, embedded in the program as SPIR-V.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace fire3dv::shaders {

// SPIR-V of the shader with this file name ("post.comp"); empty for an unknown name.
std::span<const uint32_t> embedded(std::string_view name);
std::vector<std::string_view> names();

}  // namespace fire3dv::shaders
