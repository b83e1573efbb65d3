// The compiled shaders, part of the program.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace fire3dv::shaders {

// SPIR-V of a shader by its name ("post.comp"), or empty.
std::span<const uint32_t> embedded(std::string_view name);
std::vector<std::string_view> names();

}  // namespace fire3dv::shaders
