// Files that are complete or absent, and errors that name them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::sinks {

// Writes beside the place and renames, so that no one ever sees half a file; on failure nothing is left.
Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes);

// A new and empty file for writing, in the place of what has its name. A link there is removed and not followed:
// in a folder that somebody else has made it leads to a file that nobody meant. -1 and errno when it fails.
int open_new(const std::filesystem::path& path);

Result<std::vector<uint8_t>> read_whole_file(const std::filesystem::path& path, uint64_t max_bytes);

// "No space left on device" and the like for the current errno, with the remedy where there is one.
std::string system_reason(int error_number);

}  // namespace fire3dv::sinks
