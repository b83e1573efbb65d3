#include "protocol/transport/shm/shm_copy.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "protocol/transport/shm/shm_layout.h"

#if (defined(__x86_64__) || defined(__aarch64__)) && !defined(__SANITIZE_THREAD__)
#define FIRE3DV_COPY_BY_LIBRARY 1
#else
#define FIRE3DV_COPY_BY_LIBRARY 0
#endif

namespace fire3dv::transport::shm {

#if FIRE3DV_COPY_BY_LIBRARY

namespace {

// Piece size below glibc's threshold for non-temporal stores (three quarters of the last-level cache, never
// less than this).
constexpr size_t kPieceBytes = 16 << 10;

void copy(std::byte* to, const std::byte* from, size_t bytes) {
  void* (*library)(void*, const void*, size_t) = std::memcpy;
  asm volatile("" : "+r"(library) : : "memory");  // hides from the compiler that the function is memcpy
  while (bytes != 0) {
    const size_t piece = std::min(bytes, kPieceBytes);
    library(to, from, piece);
    to += piece;
    from += piece;
    bytes -= piece;
  }
  asm volatile("" : : : "memory");
}

}  // namespace

void copy_to_shared(std::byte* shared, const std::byte* from, size_t bytes) {
  copy(shared, from, bytes);
}

void copy_from_shared(std::byte* to, const std::byte* shared, size_t bytes) {
  copy(to, shared, bytes);
}

#else

namespace {

constexpr auto relaxed = std::memory_order_relaxed;

// Shared memory is only accessed as aligned 8-byte words.
uint64_t& word_at(const std::byte* shared, size_t index) {
  return *(reinterpret_cast<uint64_t*>(const_cast<std::byte*>(shared)) + index);
}

}  // namespace

void copy_to_shared(std::byte* shared, const std::byte* from, size_t bytes) {
  // A piece may begin inside a word.
  const size_t skew = reinterpret_cast<uintptr_t>(shared) % 8;
  shared -= skew;
  size_t at = skew;
  const size_t end = skew + bytes;
  while (at < end) {
    const size_t index = at / 8;
    const size_t taken = std::min(end, 8 * (index + 1)) - at;
    uint64_t word = taken == 8 ? 0 : atomic_word(word_at(shared, index)).load(relaxed);
    std::memcpy(reinterpret_cast<std::byte*>(&word) + at % 8, from, taken);
    atomic_word(word_at(shared, index)).store(word, relaxed);
    from += taken;
    at += taken;
  }
}

void copy_from_shared(std::byte* to, const std::byte* shared, size_t bytes) {
  for (size_t i = 0; 8 * i < bytes; ++i) {
    const uint64_t word = atomic_word(word_at(shared, i)).load(relaxed);
    std::memcpy(to + 8 * i, &word, std::min<size_t>(8, bytes - 8 * i));
  }
}

#endif

}  // namespace fire3dv::transport::shm
