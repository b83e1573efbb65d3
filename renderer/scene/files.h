// Reading the asset's files. An asset names other files by URI; only relative paths that stay in the asset's
// folder, links resolved, are followed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "protocol/error.h"

namespace fire3dv::scene {

// Bytes that are not set to zero before they are read into: assets may hold gigabytes.
struct Bytes {
  std::unique_ptr<std::byte[]> data;
  size_t size = 0;
  std::span<const std::byte> view() const { return {data.get(), size}; }
};

// Regular files only: a pipe or a device would block or never end.
Result<Bytes> read_file(const std::filesystem::path& path, uint64_t max_bytes);

class AssetFolder {
 public:
  explicit AssetFolder(const std::filesystem::path& asset);

  // The bytes that a URI of the asset stands for: a data: URI or a file below the folder. The error says why
  // it is refused, without the asset's name.
  Result<Bytes> read(std::string_view uri, uint64_t max_bytes) const;

  // Where a URI points, or why it may not be followed.
  Result<std::filesystem::path> resolve(std::string_view uri) const;

 private:
  std::filesystem::path folder_;
};

// Text for a message: cut, and with control characters replaced, since it comes from the file.
std::string quote(std::string_view text);

}  // namespace fire3dv::scene
