#include "base/digest.h"

#include <sodium.h>

#include <atomic>
#include <bit>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "base/files.h"
#include "base/parallel.h"
#include "base/text.h"

namespace fire3dv {
namespace {

constexpr size_t kChunk = size_t{1} << 20;

void hash(std::span<const std::byte> bytes, uint8_t* digest) {
  crypto_generichash(digest, sizeof(Digest), reinterpret_cast<const unsigned char*>(bytes.data()),
                     bytes.size(), nullptr, 0);
}

// hash_chunk: writes the digest of the chunk at an offset.
Digest digest_of_chunks(uint64_t size,
                        const std::function<void(uint64_t offset, size_t size, uint8_t*)>& hash_chunk) {
  static const int ready = sodium_init();  // selects the fastest implementation for this CPU
  FIRE3DV_ASSERT(ready >= 0);
  const uint64_t count = (size + kChunk - 1) / kChunk;
  std::vector<uint8_t> digests(count * sizeof(Digest) + sizeof(size));
  parallel_for(count, [&](size_t i) {
    hash_chunk(i * kChunk, static_cast<size_t>(std::min<uint64_t>(kChunk, size - i * kChunk)),
               &digests[i * sizeof(Digest)]);
  });
  std::memcpy(&digests[count * sizeof(Digest)], &size, sizeof(size));
  Digest all;
  hash(std::as_bytes(std::span(digests)), all.data());
  return all;
}

}  // namespace

Digest digest_of(std::span<const std::byte> bytes) {
  return digest_of_chunks(bytes.size(), [&](uint64_t offset, size_t size, uint8_t* digest) {
    hash(bytes.subspan(offset, size), digest);
  });
}

Result<Digest> digest_of_file(const std::filesystem::path& path, uint64_t max_bytes) {
  Result<OpenFile> file = OpenFile::open(path, max_bytes);
  if (!file) return file.error();
  std::atomic<bool> whole{true};
  const Digest digest = digest_of_chunks(file->size(), [&](uint64_t offset, size_t size, uint8_t* out) {
    const auto chunk = std::make_unique_for_overwrite<std::byte[]>(size);
    if (!file->read(offset, {chunk.get(), size})) whole = false;
    hash({chunk.get(), size}, out);
  });
  if (!whole) return Error{quote(path.string()) + " changed while it was read"};
  return digest;
}

std::string hex(std::span<const uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

void Checksum::add_block(const std::byte* block) {
  for (size_t lane = 0; lane < lanes_.size(); ++lane) {
    uint64_t word = 0;
    std::memcpy(&word, block + lane * sizeof(word), sizeof(word));
    // An odd factor is invertible; the rotation moves the well-mixed high bits down.
    lanes_[lane] = std::rotl((lanes_[lane] ^ word) * 0x9e3779b97f4a7c15u, 29);
  }
}

void Checksum::add(std::span<const std::byte> bytes) {
  size_ += bytes.size();
  size_t at = 0;
  for (; at + kBlock <= bytes.size(); at += kBlock) add_block(bytes.data() + at);
  if (at == bytes.size()) return;
  std::array<std::byte, kBlock> last{};
  std::memcpy(last.data(), bytes.data() + at, bytes.size() - at);
  add_block(last.data());
}

uint64_t Checksum::value() const {
  uint64_t mixed = size_;
  for (const uint64_t lane : lanes_) {
    mixed = (mixed ^ lane) * 0xd6e8feb86659fd93u;
    mixed ^= mixed >> 32;
  }
  return mixed;
}

}  // namespace fire3dv
