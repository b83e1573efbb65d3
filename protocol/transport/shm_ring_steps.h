// The steps by which a message is written into a slot of a broadcast ring and read out of it, in the order of
// SPEC-transport 1.3. They are written over "a memory": the mapped segment (shm_ring.cpp), or a model of what
// the C++ memory model allows (tests/unit/transport/ring_model.h), in which a test goes through everything
// that a reader can see of a writer that stops anywhere. There is one text, so that what is proved is what
// runs.
//
// The order of accesses follows H.-J. Boehm, "Can Seqlocks Get Along with Programming Language Memory
// Models?" (MSPC 2012): fences stand between the sequence and the payload, and a torn read is thrown away.
// How the payload is copied without being a data race: shm_copy.h.
#pragma once

#include <atomic>
#include <cstdint>

namespace fire3dv::transport::shm {

// What is one atomic word: three of the slot at hand, and the ring's own counter.
enum class RingWord { sequence, bytes, tag, published };

enum class ReadOutcome { ok, lapped, corrupt };

// memory.copy_in() stores the message's bytes, in any order.
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

// memory.copy_out(bytes) loads that many bytes, in any order. What it got is the message only when this is
// ok.
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
