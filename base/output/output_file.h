// Output of a program to a file that the user names: like a shell redirection, but atomic.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/error.h"

namespace fire3dv::base {

// The error is the system's text alone.
Result<void> write_descriptor(int fd, std::span<const std::byte> bytes);

// Follows links and keeps a file's mode; new files get the umask's. Pipes and devices are written directly.
// Errors name the file.
Result<void> write_output(const std::filesystem::path& path, std::span<const std::byte> bytes);

// True if `path` is the file, pipe or terminal that is open as `fd`: /dev/stdout and its like.
bool is_open_as(int fd, const std::filesystem::path& path);

}  // namespace fire3dv::base
