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
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/digest.h"

namespace fire3dv::scene {

// Bytes that are not set to zero before they are read into: assets may hold gigabytes.
struct Bytes {
  std::unique_ptr<std::byte[]> data;
  size_t size = 0;
  std::span<const std::byte> view() const { return {data.get(), size}; }
};

// A regular file, for reading, on any number of threads at once.
class OpenFile {
 public:
  static Result<OpenFile> open(const std::filesystem::path& path, uint64_t max_bytes);
  OpenFile(OpenFile&& other) noexcept;
  ~OpenFile();
  OpenFile& operator=(const OpenFile&) = delete;

  uint64_t size() const { return size_; }
  // False when the file does not have them, or not any more; errno is 0 then.
  bool read(uint64_t offset, std::span<std::byte> to) const;

 private:
  OpenFile() = default;
  int fd_ = -1;
  uint64_t size_ = 0;
};

// Regular files only: a pipe or a device would block or never end.
Result<Bytes> read_file(const std::filesystem::path& path, uint64_t max_bytes);

// A file that an asset consists of, as it was when it was read.
struct SourceFile {
  std::string uri;  // as the asset names it; empty: the asset's own file
  Digest digest{};
};

class AssetFolder {
 public:
  // log: gets the files that are read; may be null.
  explicit AssetFolder(const std::filesystem::path& asset, std::vector<SourceFile>* log = nullptr);

  // Of an asset that came without files: only data: URIs are followed.
  static AssetFolder none();

  // The bytes that a URI of the asset stands for: a data: URI or a file below the folder. The error says why
  // it is refused, without the asset's name.
  Result<Bytes> read(std::string_view uri, uint64_t max_bytes) const;

  // Where a URI points, or why it may not be followed.
  Result<std::filesystem::path> resolve(std::string_view uri) const;

 private:
  AssetFolder() = default;

  std::filesystem::path folder_;
  bool has_files_ = true;
  std::vector<SourceFile>* log_ = nullptr;
};

// Text from a file or a peer in quotation marks, for messages: printable and cut, see protocol/base/text.h.
std::string quote(std::string_view text);

}  // namespace fire3dv::scene
