// Files that an asset consists of. An asset names other files by URI; only relative paths that stay in the
// asset's folder, links resolved, are followed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/text.h"

namespace fire3dv::scene {

// A file that an asset names, as it was when it was read.
struct SourceFile {
  std::string uri;  // as in the asset; empty: the asset file itself
  Digest digest{};  // zeros: it could not be read
};

class AssetFolder {
 public:
  // log: receives the files that read() was called for; may be null.
  explicit AssetFolder(const std::filesystem::path& asset, std::vector<SourceFile>* log = nullptr);

  // Folder of an asset without files: only data: URIs are followed.
  static AssetFolder none();

  // The bytes that a URI of the asset stands for: a data: URI or a file below the folder. The error says why
  // it is refused, without the asset's name.
  Result<FileBytes> read(std::string_view uri, uint64_t max_bytes) const;

  // Resolves a URI to a path, or explains why it must not be followed.
  Result<std::filesystem::path> resolve(std::string_view uri) const;

 private:
  AssetFolder() = default;

  std::filesystem::path folder_;
  bool has_files_ = true;
  std::vector<SourceFile>* log_ = nullptr;
};

}  // namespace fire3dv::scene
