// Seqlock steps of writing and reading a slot of a broadcast ring, in the order of SPEC-transport 1.3.
// Templates over a Memory: the mapped segment (shm_ring.cpp), or a model of the C++ memory model
// (tests/unit/transport/ring_model.h). The test explores every state that a reader can observe of a stopped
// writer; verified and production code are the same. Order of accesses: docs/design/shared-memory.md. Payload
// copy: shm_copy.h.
#pragma once

#include <atomic>
#include <cstdint>

namespace fire3dv::transport::shm {

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

}  // namespace fire3dv::transport::shm
