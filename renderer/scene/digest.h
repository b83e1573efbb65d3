// What identifies bytes: a digest for files that come from anywhere, which nobody can find two files for, and
// a checksum for files of our own, which tells damage at the speed of memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "protocol/error.h"

namespace fire3dv::scene {

using Digest = std::array<uint8_t, 32>;

// BLAKE2b of the BLAKE2b digests of all mebibytes, found on all cores.
Digest digest_of(std::span<const std::byte> bytes);
// The same of a file's bytes. Regular files only.
Result<Digest> digest_of_file(const std::filesystem::path& path, uint64_t max_bytes);

std::string hex(std::span<const uint8_t> bytes);

// Bytes may come in pieces; each but the last one has a size that kBlock divides.
class Checksum {
 public:
  static constexpr size_t kBlock = 32;
  void add(std::span<const std::byte> bytes);
  uint64_t value() const;

 private:
  void add_block(const std::byte* block);

  std::array<uint64_t, 4> lanes_{1, 2, 3, 4};
  uint64_t size_ = 0;
};

}  // namespace fire3dv::scene
