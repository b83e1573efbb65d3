// Files that can be made again: written whole or not at all, whoever else writes the same at the time.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::scene {

// Beside its place, under a name of its own, then renamed. Only this user can read it, unless told otherwise.
Result<void> write_atomically(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces, mode_t mode = 0600);

// Removes the least recently used files whose names end so, until the rest holds at most so many bytes, and
// what writers that were killed have left behind. Faults are no one's concern: what cannot be removed stays.
void remove_oldest(const std::filesystem::path& folder, std::string_view ending, uint64_t most_bytes);

// Makes a file the most recently used one.
void touch(const std::filesystem::path& path);

}  // namespace fire3dv::scene
