#include "protocol/transport/shm/shm_ring.h"

#include <algorithm>
#include <cstring>

#include "base/error.h"

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

namespace {

SlotHeader& slot_at(std::byte* slots, size_t stride, uint64_t mask, uint64_t number) {
  return *reinterpret_cast<SlotHeader*>(slots + ((number - 1) & mask) * stride);
}

// Mapped segment as the Memory of write_steps() and read_steps().
class SlotMemory {
 public:
  SlotMemory(SlotHeader& slot, uint64_t& published) : slot_(slot), published_(published) {}

  void store(RingWord word, uint64_t value, std::memory_order order) { at(word).store(value, order); }
  uint64_t load(RingWord word, std::memory_order order) { return at(word).load(order); }
  void fence(std::memory_order order) { std::atomic_thread_fence(order); }

 protected:
  std::byte* payload() { return reinterpret_cast<std::byte*>(&slot_) + kSlotHeaderBytes; }

 private:
  std::atomic_ref<uint64_t> at(RingWord word) {
    switch (word) {
      case RingWord::sequence:
        return atomic_word(slot_.sequence);
      case RingWord::bytes:
        return atomic_word(slot_.bytes);
      case RingWord::tag:
        return atomic_word(slot_.tag);
      case RingWord::published:
        break;
    }
    return atomic_word(published_);
  }

  SlotHeader& slot_;
  uint64_t& published_;
};

struct WriterMemory : SlotMemory {
  const wire::MessagePieces& message;

  WriterMemory(SlotHeader& slot, uint64_t& published, const wire::MessagePieces& pieces)
      : SlotMemory(slot, published), message(pieces) {}
  void copy_in() {
    copy_to_shared(payload(), message.head.data(), message.head.size());
    copy_to_shared(payload() + message.head.size(), message.body.data(), message.body.size());
  }
};

struct ReaderMemory : SlotMemory {
  std::vector<std::byte>& message;

  ReaderMemory(SlotHeader& slot, uint64_t& published, std::vector<std::byte>& into)
      : SlotMemory(slot, published), message(into) {}
  void copy_out(uint64_t bytes) {
    message.resize(bytes);
    copy_from_shared(message.data(), payload(), bytes);
  }
};

}  // namespace

RingWriter::RingWriter(std::byte* segment, const RingGeometry& geometry, uint64_t& published)
    : slots_(segment + geometry.offset),
      stride_(geometry.stride),
      capacity_(geometry.capacity),
      mask_(geometry.count - 1),
      published_(&published) {}

void RingWriter::write(const wire::MessagePieces& message, uint64_t tag) noexcept {
  FIRE3DV_ASSERT(message.size() <= capacity_);
  const uint64_t number = ++number_;
  WriterMemory memory(slot_at(slots_, stride_, mask_, number), *published_, message);
  write_steps(memory, number, message.size(), tag);
}

RingReader::RingReader(std::byte* segment, const RingGeometry& geometry, uint64_t& published)
    : slots_(segment + geometry.offset),
      stride_(geometry.stride),
      capacity_(geometry.capacity),
      mask_(geometry.count - 1),
      published_(&published) {}

uint64_t RingReader::published() const {
  SlotMemory memory(slot_at(slots_, stride_, mask_, 1), *published_);
  return published_step(memory);
}

RingReader::Outcome RingReader::read(uint64_t number, std::vector<std::byte>& message, uint64_t& tag) const {
  ReaderMemory memory(slot_at(slots_, stride_, mask_, number), *published_, message);
  return read_steps(memory, number, capacity_, tag);
}

}  // namespace fire3dv::transport::shm
