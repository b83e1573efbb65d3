#include "protocol/transport/shm/shm_states.h"

#include "base/error.h"
#include "protocol/transport/core/byte_order.h"
#include "protocol/transport/shm/shm_ring.h"

// Access order as in shm_ring.cpp: `begun` is to a half's bytes what the sequence number is to a slot.

namespace fire3dv::transport::shm {
namespace {

constexpr auto relaxed_order = std::memory_order_relaxed;
constexpr auto acquire = std::memory_order_acquire;
constexpr auto release_order = std::memory_order_release;

constexpr size_t kStateRecordHeaderBytes = 24;  // u64 length | u64 number | u64 tag
constexpr int kTries = 4;

}  // namespace

size_t state_record_bytes(size_t message_bytes) {
  return kStateRecordHeaderBytes + (message_bytes + 7) / 8 * 8;
}

size_t state_bytes(const KeyedStates& states) {
  return states.bytes() + states.count() * (kStateRecordHeaderBytes + 7);
}

StatesWriter::StatesWriter(std::byte* segment, const StatesGeometry& geometry, StatesWords& words)
    : region_(segment + geometry.offset), half_bytes_(geometry.half_bytes), words_(&words) {}

size_t StatesWriter::append(std::byte* to, const KeyedState& state, uint64_t tag) const {
  const wire::Bytes& message = *state.message;
  std::byte header[kStateRecordHeaderBytes];
  put_le<uint64_t>(header, message.size());
  put_le<uint64_t>(header + 8, state.number);
  put_le<uint64_t>(header + 16, tag);
  copy_to_shared(to, header, sizeof header);
  copy_to_shared(to + kStateRecordHeaderBytes, message.data(), message.size());
  return state_record_bytes(message.size());
}

void StatesWriter::put(const KeyedStates& states, uint64_t tag) noexcept {
  const KeyedState& newest = states.in_order().rbegin()->second;
  if (generation_ == 0 || state_record_bytes(newest.message->size()) > half_bytes_ - used_)
    return restart_epoch(states, tag);
  used_ += append(half(generation_) + used_, newest, tag);
  atomic_word(words_->committed[generation_ & 1].value).store(used_, release_order);
}

void StatesWriter::restart_epoch(const KeyedStates& states, uint64_t tag) noexcept {
  FIRE3DV_ASSERT(state_bytes(states) <= half_bytes_);
  const uint64_t generation = ++generation_;
  atomic_word(words_->begun[generation & 1].value).store(generation, relaxed_order);
  std::atomic_thread_fence(release_order);
  used_ = 0;
  for (const auto& [number, state] : states.in_order()) used_ += append(half(generation) + used_, state, tag);
  atomic_word(words_->committed[generation & 1].value).store(used_, release_order);
  atomic_word(words_->generation.value).store(generation, release_order);
}

StatesReader::StatesReader(std::byte* segment, const StatesGeometry& geometry, StatesWords& words)
    : region_(segment + geometry.offset), half_bytes_(geometry.half_bytes), words_(&words) {}

bool StatesReader::has_unread() const {
  if (half_bytes_ == 0) return false;
  const uint64_t generation = atomic_word(words_->generation.value).load(acquire);
  return generation != generation_ ||
         (generation != 0 &&
          atomic_word(words_->committed[generation & 1].value).load(relaxed_order) != read_);
}

// Copies unread records of the half before `generation` into copy_. Returns false if there are none, or if
// the writer has begun to overwrite them.
bool StatesReader::finish_previous_half(uint64_t generation) {
  if (generation_ == 0 || generation != generation_ + 1) return false;
  const size_t half = generation_ & 1;
  const size_t end = atomic_word(words_->committed[half].value).load(acquire);
  if (end > half_bytes_ || end <= read_ || end % 8 != 0) return false;
  copy_.resize(end - read_);
  copy_from_shared(copy_.data(), region_ + half * half_bytes_ + read_, copy_.size());
  std::atomic_thread_fence(acquire);
  if (atomic_word(words_->begun[half].value).load(relaxed_order) != generation_) return false;
  read_ = end;
  return true;
}

// Copies new records into copy_.
StatesReader::Look StatesReader::look() {
  const uint64_t generation = atomic_word(words_->generation.value).load(acquire);
  if (generation == 0) return generation_ == 0 ? Look::nothing : Look::corrupt;
  if (generation != generation_) {
    if (generation < generation_) return Look::corrupt;  // a correct publisher never counts backwards
    if (finish_previous_half(generation)) return Look::news;
    generation_ = generation;
    read_ = 0;
  }
  const size_t end = atomic_word(words_->committed[generation & 1].value).load(acquire);
  const bool fits = end <= half_bytes_ && end >= read_ && end % 8 == 0;
  if (fits) {
    copy_.resize(end - read_);
    copy_from_shared(copy_.data(), region_ + (generation & 1) * half_bytes_ + read_, copy_.size());
  }
  std::atomic_thread_fence(acquire);
  if (atomic_word(words_->begun[generation & 1].value).load(relaxed_order) != generation) return Look::lapped;
  if (!fits) return Look::corrupt;
  read_ = end;
  return copy_.empty() ? Look::nothing : Look::news;
}

StatesReader::Outcome StatesReader::drain(uint64_t& last, const OnState& on_state) {
  if (half_bytes_ == 0) return Outcome::ok;
  for (int tries = 0; tries < kTries; ++tries) {
    switch (look()) {
      case Look::nothing:
        return Outcome::ok;
      case Look::news:
        if (hand_on(last, on_state) == Outcome::corrupt) return Outcome::corrupt;
        break;
      case Look::lapped:
        break;
      case Look::corrupt:
        return Outcome::corrupt;
    }
  }
  return Outcome::ok;
}

StatesReader::Outcome StatesReader::hand_on(uint64_t& last, const OnState& on_state) const {
  std::span<const std::byte> left(copy_);
  while (!left.empty()) {
    if (left.size() < kStateRecordHeaderBytes) return Outcome::corrupt;
    const uint64_t bytes = get_le<uint64_t>(left.data());
    const uint64_t number = get_le<uint64_t>(left.data() + 8);
    const uint64_t tag = get_le<uint64_t>(left.data() + 16);
    if (bytes > left.size() || state_record_bytes(bytes) > left.size()) return Outcome::corrupt;
    // A new log repeats records that its reader has already received.
    if (number > last) {
      last = number;
      if (!on_state(tag, left.subspan(kStateRecordHeaderBytes, bytes))) return Outcome::corrupt;
    }
    left = left.subspan(state_record_bytes(bytes));
  }
  return Outcome::ok;
}

}  // namespace fire3dv::transport::shm
