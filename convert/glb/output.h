// Output of a converted scene: like a shell redirection to -o, but atomic.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/error.h"

namespace fire3dv::convert {

Result<void> write_descriptor(int fd, std::span<const std::byte> bytes);

// Follows links and keeps a file's mode; new files get the umask's. Pipes and devices are written directly.
Result<void> write_output(const std::filesystem::path& path, std::span<const std::byte> bytes);

// Writes a cache file to a possibly shared folder: replaces links, and only this user can read the file.
// Refuses to replace anything but a file.
Result<void> write_cache_entry(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace fire3dv::convert
