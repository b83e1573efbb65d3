// Cache files of converted scenes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/error.h"

namespace fire3dv::convert {

// Writes a cache file to a possibly shared folder: replaces links, and only this user can read the file.
// Refuses to replace anything but a file.
Result<void> write_cache_entry(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace fire3dv::convert
