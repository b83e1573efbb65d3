// Content hashes: a collision-resistant digest for untrusted files, and a fast checksum that detects damage
// of our own files.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/error.h"

namespace fire3dv {

using Digest = std::array<uint8_t, 32>;

// BLAKE2b over the BLAKE2b digests of all 1 MiB chunks, computed on all cores.
Digest digest_of(std::span<const std::byte> bytes);
// Same for a regular file.
Result<Digest> digest_of_file(const std::filesystem::path& path, uint64_t max_bytes);

std::string hex(std::span<const uint8_t> bytes);

// Checksum of a byte stream. The size of each piece but the last must be a multiple of kBlock.
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

}  // namespace fire3dv
