// Cache file storage: atomic writes and eviction of least recently used files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace fire3dv::scene {

// Replaces a file atomically, readable by this user only. Contents are flushed to the disk, the name is not:
// a power cut loses the entry or leaves it complete.
Result<void> write_cache_file(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces);

// Evicts the least recently used files with this ending until the rest has at most most_bytes. Also removes
// temporary files of killed writers. Errors are ignored.
void remove_oldest(const std::filesystem::path& folder, std::string_view ending, uint64_t most_bytes);

// Marks a file as most recently used.
void touch(const std::filesystem::path& path);

}  // namespace fire3dv::scene
