// Keyed states in shared memory: a log in one half of a region, and when that is full what is newest of each
// key in the other half, which then becomes the log. What a reader can see was written before it became
// visible, so that a writer that dies anywhere leaves the states as they were before or after.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "protocol/transport/keyed_states.h"
#include "protocol/transport/shm_layout.h"

namespace fire3dv::transport::shm {

// What a snapshot of these needs of a half.
size_t state_bytes(const KeyedStates& states);
size_t state_record_bytes(size_t message_bytes);

class StatesWriter {
 public:
  StatesWriter() = default;
  StatesWriter(std::byte* segment, const StatesGeometry& geometry, StatesWords& words);

  size_t capacity() const { return half_bytes_; }

  // `states` with its newest put: that alone when there is room behind what is there, else all of them in the
  // other half. They must fit a half. Bounded; neither locks nor allocates. tag: number of the description in
  // force.
  void put(const KeyedStates& states, uint64_t tag) noexcept;
  // All of them in the other half.
  void begin_again(const KeyedStates& states, uint64_t tag) noexcept;

 private:
  std::byte* half(uint64_t generation) const { return region_ + (generation & 1) * half_bytes_; }
  size_t append(std::byte* to, const KeyedState& state, uint64_t tag) const;

  std::byte* region_ = nullptr;
  size_t half_bytes_ = 0;
  StatesWords* words_ = nullptr;
  uint64_t generation_ = 0;  // private, so that nobody else can upset it
  size_t used_ = 0;          // of its half
};

class StatesReader {
 public:
  enum class Outcome { ok, corrupt };
  // tag: number of the description that the message belongs to.
  using OnState = std::function<bool(uint64_t tag, std::span<const std::byte> message)>;

  StatesReader() = default;
  StatesReader(std::byte* segment, const StatesGeometry& geometry, StatesWords& words);

  bool has_news() const;
  // Hands on what was put after number `last`, oldest first, and raises it. A reader that the writer laps
  // tries again, and after some tries leaves it to the next call. Stops when on_state says false.
  Outcome drain(uint64_t& last, const OnState& on_state);

 private:
  enum class Look { nothing, news, lapped, corrupt };
  Look look();
  Outcome hand_on(uint64_t& last, const OnState& on_state) const;

  std::byte* region_ = nullptr;
  size_t half_bytes_ = 0;
  StatesWords* words_ = nullptr;
  uint64_t generation_ = 0;
  size_t read_ = 0;  // of its half
  std::vector<std::byte> copy_;
};

}  // namespace fire3dv::transport::shm
