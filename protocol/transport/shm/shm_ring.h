// Broadcast ring in shared memory: one wait-free writer and any number of readers, unknown to the writer. A
// message becomes readable when it is complete; a lapped reader detects it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "protocol/transport/shm/shm_layout.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::shm {

// Seqlock steps of writing and reading a slot of a broadcast ring, in the order of SPEC-transport 1.3.
// Templates over a Memory: the mapped segment (shm_ring.cpp), or a model of the C++ memory model
// (tests/unit/protocol/transport/shm/ring_model.h). The test explores every state that a reader can observe
// of a stopped writer; verified and production code are the same. Order of accesses:
// docs/design/shared-memory.md.

// Atomic words: three of the slot, and the ring's counter.
enum class RingWord { sequence, bytes, tag, published };

enum class ReadOutcome { ok, lapped, corrupt };

// memory.copy_in() stores the message's bytes in any order.
template <typename Memory>
void write_steps(Memory& memory, uint64_t number, uint64_t bytes, uint64_t tag) {
  memory.store(RingWord::sequence, 2 * number - 1, std::memory_order_relaxed);
  memory.fence(std::memory_order_release);
  memory.store(RingWord::bytes, bytes, std::memory_order_relaxed);
  memory.store(RingWord::tag, tag, std::memory_order_relaxed);
  memory.copy_in();
  memory.store(RingWord::sequence, 2 * number, std::memory_order_release);
  memory.store(RingWord::published, number, std::memory_order_release);
}

template <typename Memory>
uint64_t published_step(Memory& memory) {
  return memory.load(RingWord::published, std::memory_order_acquire);
}

// memory.copy_out(bytes) loads that many bytes in any order. They are the message only if the result is ok.
template <typename Memory>
ReadOutcome read_steps(Memory& memory, uint64_t number, uint64_t capacity, uint64_t& tag) {
  if (memory.load(RingWord::sequence, std::memory_order_acquire) != 2 * number) return ReadOutcome::lapped;
  const uint64_t bytes = memory.load(RingWord::bytes, std::memory_order_relaxed);
  tag = memory.load(RingWord::tag, std::memory_order_relaxed);
  const bool fits = bytes <= capacity;
  if (fits) memory.copy_out(bytes);
  memory.fence(std::memory_order_acquire);
  if (memory.load(RingWord::sequence, std::memory_order_relaxed) != 2 * number) return ReadOutcome::lapped;
  return fits ? ReadOutcome::ok : ReadOutcome::corrupt;
}

// Seqlock payload copies from and to shared memory that another process may access concurrently. The caller
// discards the result if the slot's sequence number changed.
//
// Implements the byte-wise atomic memcpy of WG21 paper P1478: memcpy on the machines that shm_ring.cpp names,
// relaxed atomic words on others and for ThreadSanitizer. Reasons: docs/design/shared-memory.md.
//
// Shared memory is a whole number of 8-byte words.
void copy_to_shared(std::byte* shared, const std::byte* from, size_t bytes);
// `shared` must be 8-byte aligned.
void copy_from_shared(std::byte* to, const std::byte* shared, size_t bytes);

// --- ring

class RingWriter {
 public:
  RingWriter() = default;
  RingWriter(std::byte* segment, const RingGeometry& geometry, uint64_t& published);

  size_t capacity() const { return capacity_; }
  uint64_t written() const { return number_; }

  // Requires message.size() <= capacity(). Bounded time; no lock, system call or allocation.
  void write(const wire::MessagePieces& message, uint64_t tag) noexcept;

 private:
  std::byte* slots_ = nullptr;
  size_t stride_ = 0;
  size_t capacity_ = 0;
  uint64_t mask_ = 0;
  uint64_t* published_ = nullptr;
  uint64_t number_ = 0;  // number of the newest message; private, so that no other process can corrupt it
};

class RingReader {
 public:
  using Outcome = ReadOutcome;

  RingReader() = default;
  RingReader(std::byte* segment, const RingGeometry& geometry, uint64_t& published);

  uint64_t published() const;
  uint64_t count() const { return mask_ + 1; }

  // Copies message `number`. lapped: the writer has reused the slot for a newer one, or is about to.
  Outcome read(uint64_t number, std::vector<std::byte>& message, uint64_t& tag) const;

 private:
  std::byte* slots_ = nullptr;
  size_t stride_ = 0;
  size_t capacity_ = 0;
  uint64_t mask_ = 0;
  uint64_t* published_ = nullptr;
};

}  // namespace fire3dv::transport::shm
