// Broadcast ring in shared memory: one wait-free writer and any number of readers, unknown to the writer. A
// message becomes readable when it is complete; a lapped reader detects it.
#pragma once

#include <span>
#include <vector>

#include "protocol/transport/shm/shm_layout.h"
#include "protocol/transport/shm/shm_ring_steps.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::shm {

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
