// Cache file: key, checksum and data. A read returns exactly the written bytes or an error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/base/digest.h"
#include "protocol/base/error.h"

namespace fire3dv::app {

// Type of the files in a cache folder.
struct CacheFileType {
  std::string_view magic;   // 8 bytes
  std::string_view ending;  // file extension
  const char* holds;        // for messages: "pipelines"
};
// Limit of one file, and of all files of a type in a folder.
constexpr uint64_t kMaxCacheBytes = uint64_t{256} << 20;

// File path of a cache key.
std::filesystem::path cache_path(const std::filesystem::path& folder, const CacheFileType& type,
                                 const Digest& kind);
// Replaces the file atomically.
Result<void> store_cache_file(const std::filesystem::path& path, const CacheFileType& type,
                              const Digest& kind, std::span<const std::byte> data);
// Errors name the file and the reason: other key or type, damaged, too long, or missing.
Result<std::vector<std::byte>> read_cache_file(const std::filesystem::path& path, const CacheFileType& type,
                                               const Digest& kind);
// Writes the file to cache_path(), creates the folder if needed, and evicts the oldest files over the limit.
Result<void> store_in_cache(const std::filesystem::path& folder, const CacheFileType& type,
                            const Digest& kind, std::span<const std::byte> data);

}  // namespace fire3dv::app
