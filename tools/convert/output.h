// Where a converted scene goes: what -o names, as a shell's > would take it, but whole or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "protocol/error.h"

namespace fire3dv::convert {

Result<void> write_descriptor(int fd, std::span<const std::byte> bytes);

// A link is followed, a file keeps its mode, a new one gets the umask's; a pipe or a device is written to.
Result<void> write_output(const std::filesystem::path& path, std::span<const std::byte> bytes);

// For a folder that others may write to: a link is replaced, and only this user can read the file. What is
// there already and is no file is left alone.
Result<void> write_kept(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace fire3dv::convert
