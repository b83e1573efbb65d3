// A broadcast ring in shared memory: one writer that never waits, any number of readers that the writer knows
// nothing of. A message is readable only when complete; a reader that was lapped notices.
#pragma once

#include <span>
#include <vector>

#include "protocol/transport/shm_layout.h"
#include "protocol/transport/shm_ring_steps.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::shm {

class RingWriter {
 public:
  RingWriter() = default;
  RingWriter(std::byte* segment, const RingGeometry& geometry, uint64_t& published);

  size_t capacity() const { return capacity_; }
  uint64_t written() const { return number_; }

  // message.size() must not be above capacity(). Bounded, without lock, system call or allocation.
  void write(const wire::MessagePieces& message, uint64_t tag) noexcept;

 private:
  std::byte* slots_ = nullptr;
  size_t stride_ = 0;
  size_t capacity_ = 0;
  uint64_t mask_ = 0;
  uint64_t* published_ = nullptr;
  uint64_t number_ = 0;  // of the newest message; private, so that nobody else can upset it
};

class RingReader {
 public:
  using Outcome = ReadOutcome;

  RingReader() = default;
  RingReader(std::byte* segment, const RingGeometry& geometry, uint64_t& published);

  uint64_t published() const;
  uint64_t count() const { return mask_ + 1; }

  // Copies message `number` out. `lapped`: the writer has taken the slot for a newer one (or is about to).
  Outcome read(uint64_t number, std::vector<std::byte>& message, uint64_t& tag) const;

 private:
  std::byte* slots_ = nullptr;
  size_t stride_ = 0;
  size_t capacity_ = 0;
  uint64_t mask_ = 0;
  uint64_t* published_ = nullptr;
};

}  // namespace fire3dv::transport::shm
