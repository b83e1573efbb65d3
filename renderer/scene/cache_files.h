// Files of a cache: written atomically, removed when they are old.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::scene {

// Replaces a file atomically; only this user can read it. Its contents are flushed to the disk, its name is
// not: a power cut loses an entry of the cache or keeps it complete.
Result<void> write_cache_file(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces);

// Removes the least recently used files whose names end so, until the rest holds at most so many bytes, and
// what writers that were killed have left behind. Faults are no one's concern: what cannot be removed stays.
void remove_oldest(const std::filesystem::path& folder, std::string_view ending, uint64_t most_bytes);

// Makes a file the most recently used one.
void touch(const std::filesystem::path& path);

}  // namespace fire3dv::scene
