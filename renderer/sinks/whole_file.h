// Files that are complete or absent, and errors that name them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "protocol/base/atomic_file.h"
#include "protocol/error.h"

namespace fire3dv::sinks {

// Replaces a file atomically; on failure nothing is left of the new one.
Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes,
                              base::Durability durability = base::Durability::contents_and_name);

Result<std::vector<uint8_t>> read_whole_file(const std::filesystem::path& path, uint64_t max_bytes);

using base::system_reason;

}  // namespace fire3dv::sinks
