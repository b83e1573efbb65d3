// Radiance HDR (.hdr) reader for equirectangular environment maps.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "protocol/base/error.h"
#include "renderer/scene/textures/environment.h"

namespace fire3dv::scene {

constexpr uint32_t kMaxEnvironmentWidth = 8192, kMaxEnvironmentHeight = 4096;

Result<EnvironmentImage> load_environment(const std::filesystem::path& path);

// name: file name for errors.
Result<EnvironmentImage> decode_radiance_file(std::span<const std::byte> bytes, const std::string& name);

}  // namespace fire3dv::scene
