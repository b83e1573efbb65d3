// Writer and reader of tar archives (POSIX ustar) with regular files: no times, owners or links, so that the
// same files give the same bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"

namespace fire3dv::dataset {

// Bytes that a file of this size takes in an archive.
constexpr uint64_t tar_bytes(uint64_t file_bytes) {
  constexpr uint64_t kBlock = 512;
  return kBlock + (file_bytes + kBlock - 1) / kBlock * kBlock;
}

// Size of an archive whose files take so many bytes: two empty blocks end it, and it is filled up to a whole
// record.
constexpr uint64_t archive_bytes(uint64_t files_bytes) {
  constexpr uint64_t kEnd = 2 * 512, kRecord = 20 * 512;
  return (files_bytes + kEnd + kRecord - 1) / kRecord * kRecord;
}

class TarFile {
 public:
  static Result<TarFile> create(const std::filesystem::path& path);

  // name: at most 99 bytes.
  Result<void> add(const std::string& name, std::span<const uint8_t> bytes);
  // Ends the archive; it appears under its name. Returns its size.
  Result<uint64_t> finish();

 private:
  explicit TarFile(base::AtomicFile file) : file_(std::move(file)) {}
  base::AtomicFile file_;
  uint64_t bytes_ = 0;
};

// Reads a file of an archive that TarFile wrote. Untrusted bytes. The error names the archive.
Result<std::vector<uint8_t>> read_tar_file(const std::filesystem::path& archive, const std::string& name,
                                           uint64_t max_bytes);

}  // namespace fire3dv::dataset
