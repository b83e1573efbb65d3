// Radiance pictures (.hdr): equirectangular images of what surrounds a scene, as photographers share them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "protocol/error.h"
#include "renderer/scene/environment.h"

namespace fire3dv::scene {

constexpr uint32_t kMaxEnvironmentWidth = 8192, kMaxEnvironmentHeight = 4096;

Result<EnvironmentImage> load_environment(const std::filesystem::path& path);

// name: for the error's sentence.
Result<EnvironmentImage> decode_radiance_file(std::span<const std::byte> bytes, const std::string& name);

}  // namespace fire3dv::scene
