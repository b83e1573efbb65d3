// Output of a program to a file that the user names. A regular file appears whole or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/error.h"

namespace fire3dv::base {

// The error is the system's text alone.
Result<void> write_descriptor(int fd, std::span<const std::byte> bytes);

// Follows symbolic links. A regular file is replaced by a new one with its mode, and with this process's user
// as owner; its hard links keep the old contents. New files get the umask's mode. Pipes, devices and open
// descriptors (/dev/stderr, /dev/fd/3) are written directly: a file behind a descriptor is continued. Errors
// name the file.
Result<void> write_output(const std::filesystem::path& path, std::span<const std::byte> bytes);

// True if `path` is the file, pipe or terminal that is open as `fd`: /dev/stdout and its like.
bool is_open_as(int fd, const std::filesystem::path& path);

}  // namespace fire3dv::base
