// Keyed states in shared memory: an append-only log in one half of a region. When it is full, the newest
// value of each key is compacted into the other half. Writes precede publication, so a crash leaves either
// the old or the new states.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "protocol/transport/core/keyed_states.h"
#include "protocol/transport/shm/shm_layout.h"

namespace fire3dv::transport::shm {

// Bytes of a half that a snapshot of these states needs.
size_t state_bytes(const KeyedStates& states);
size_t state_record_bytes(size_t message_bytes);

class StatesWriter {
 public:
  StatesWriter() = default;
  StatesWriter(std::byte* segment, const StatesGeometry& geometry, StatesWords& words);

  size_t capacity() const { return half_bytes_; }

  // Publishes `states` after a put: appends the newest one, or compacts all into the other half if the log is
  // full. They must fit a half. Bounded time; no locks or allocation. tag: number of the description in
  // force.
  void put(const KeyedStates& states, uint64_t tag) noexcept;
  // Compacts all states into the other half.
  void restart_epoch(const KeyedStates& states, uint64_t tag) noexcept;

 private:
  std::byte* half(uint64_t generation) const { return region_ + (generation & 1) * half_bytes_; }
  size_t append(std::byte* to, const KeyedState& state, uint64_t tag) const;

  std::byte* region_ = nullptr;
  size_t half_bytes_ = 0;
  StatesWords* words_ = nullptr;
  uint64_t generation_ = 0;  // private, so that no other process can corrupt it
  size_t used_ = 0;          // bytes used of its half
};

class StatesReader {
 public:
  enum class Outcome { ok, corrupt };
  // tag: number of the description that the message belongs to.
  using OnState = std::function<bool(uint64_t tag, std::span<const std::byte> message)>;

  StatesReader() = default;
  StatesReader(std::byte* segment, const StatesGeometry& geometry, StatesWords& words);

  bool has_unread() const;
  // Delivers the states after number `last`, oldest first, and updates `last`. Finishes the log of the half
  // before a compacted one, so that values that were replaced meanwhile are delivered, too. If lapped,
  // retries a few times and then leaves the rest to the next call. Stops when on_state returns false.
  Outcome drain(uint64_t& last, const OnState& on_state);

 private:
  enum class Look { nothing, news, lapped, corrupt };
  Look look();
  bool finish_previous_half(uint64_t generation);
  Outcome hand_on(uint64_t& last, const OnState& on_state) const;

  std::byte* region_ = nullptr;
  size_t half_bytes_ = 0;
  StatesWords* words_ = nullptr;
  uint64_t generation_ = 0;
  size_t read_ = 0;  // bytes read of its half
  std::vector<std::byte> copy_;
};

}  // namespace fire3dv::transport::shm
