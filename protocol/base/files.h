// Regular files, read with a limit on their size. A pipe, a device or a file that shrinks while it is read is
// an error that names the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "protocol/base/error.h"

namespace fire3dv {

// Contents of a file, in memory that is not cleared before: assets may hold gigabytes.
struct FileBytes {
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
Result<FileBytes> read_file(const std::filesystem::path& path, uint64_t max_bytes);

}  // namespace fire3dv
