// Whole-file read and atomic write. Errors name the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "protocol/base/atomic_file.h"
#include "protocol/base/error.h"

namespace fire3dv {

// Replaces the file atomically; a failure leaves no new file.
Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes,
                              base::Durability durability = base::Durability::contents_and_name);

Result<std::vector<uint8_t>> read_whole_file(const std::filesystem::path& path, uint64_t max_bytes);

using base::system_reason;

}  // namespace fire3dv
