// One file of a cache: what it is for, and bytes that are the same when they come back, or do not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/digest.h"

namespace fire3dv::app {

// What a folder of such files holds.
struct KeptFileType {
  std::string_view magic;   // of 8 bytes
  std::string_view ending;  // of names
  const char* holds;        // for messages: "pipelines"
};
constexpr uint64_t kMostKeptBytes = uint64_t{256} << 20;  // of one file, and of those of a type in a folder

// Named after the kind.
std::filesystem::path kept_path(const std::filesystem::path& folder, const KeptFileType& type,
                                const scene::Digest& kind);
// Replaces the file whole, or leaves it.
Result<void> write_kept_file(const std::filesystem::path& path, const KeptFileType& type,
                             const scene::Digest& kind, std::span<const std::byte> data);
// Errors name the file and say why it is of no use: of another kind or type, damaged, too long, not there.
Result<std::vector<std::byte>> read_kept_file(const std::filesystem::path& path, const KeptFileType& type,
                                              const scene::Digest& kind);
// write_kept_file() to kept_path(), in a folder that is made where it is not there; the oldest files go.
Result<void> keep_in_folder(const std::filesystem::path& folder, const KeptFileType& type,
                            const scene::Digest& kind, std::span<const std::byte> data);

}  // namespace fire3dv::app
