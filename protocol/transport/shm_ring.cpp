#include "protocol/transport/shm_ring.h"

#include <algorithm>
#include <cstring>

#include "protocol/error.h"

// The order of accesses follows H.-J. Boehm, "Can Seqlocks Get Along with Programming Language Memory
// Models?" (MSPC 2012): the payload is written and read as relaxed atomics, so that a torn read is a value
// that gets thrown away and never a data race.

namespace fire3dv::transport::shm {
namespace {

constexpr auto relaxed = std::memory_order_relaxed;

uint64_t load_unaligned(const std::byte* from) {
  uint64_t word;
  std::memcpy(&word, from, sizeof word);
  return word;
}

// Writes the two pieces one after the other as whole words; the last word is filled up with zeros.
void store_words(uint64_t* to, const wire::MessagePieces& message) {
  const std::byte* head = message.head.data();
  const std::byte* body = message.body.data();
  size_t head_left = message.head.size();
  size_t body_left = message.body.size();
  for (; head_left >= 8; head_left -= 8, head += 8) atomic_word(*to++).store(load_unaligned(head), relaxed);
  if (head_left != 0) {
    std::byte joint[8] = {};
    std::memcpy(joint, head, head_left);
    const size_t taken = std::min(body_left, 8 - head_left);
    if (taken != 0) std::memcpy(joint + head_left, body, taken);
    body += taken;
    body_left -= taken;
    atomic_word(*to++).store(load_unaligned(joint), relaxed);
  }
  for (; body_left >= 8; body_left -= 8, body += 8) atomic_word(*to++).store(load_unaligned(body), relaxed);
  if (body_left != 0) {
    std::byte last[8] = {};
    std::memcpy(last, body, body_left);
    atomic_word(*to).store(load_unaligned(last), relaxed);
  }
}

void load_words(std::byte* to, uint64_t* from, size_t bytes) {
  for (; bytes >= 8; bytes -= 8, to += 8) {
    const uint64_t word = atomic_word(*from++).load(relaxed);
    std::memcpy(to, &word, 8);
  }
  if (bytes != 0) {
    const uint64_t word = atomic_word(*from).load(relaxed);
    std::memcpy(to, &word, bytes);
  }
}

SlotHeader& slot_at(std::byte* slots, size_t stride, uint64_t mask, uint64_t number) {
  return *reinterpret_cast<SlotHeader*>(slots + ((number - 1) & mask) * stride);
}
uint64_t* payload_of(SlotHeader& slot) {
  return reinterpret_cast<uint64_t*>(reinterpret_cast<std::byte*>(&slot) + kSlotHeaderBytes);
}

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
  SlotHeader& slot = slot_at(slots_, stride_, mask_, number);
  atomic_word(slot.sequence).store(2 * number - 1, relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  atomic_word(slot.bytes).store(message.size(), relaxed);
  atomic_word(slot.tag).store(tag, relaxed);
  store_words(payload_of(slot), message);
  atomic_word(slot.sequence).store(2 * number, std::memory_order_release);
  atomic_word(*published_).store(number, std::memory_order_release);
}

RingReader::RingReader(std::byte* segment, const RingGeometry& geometry, uint64_t& published)
    : slots_(segment + geometry.offset),
      stride_(geometry.stride),
      capacity_(geometry.capacity),
      mask_(geometry.count - 1),
      published_(&published) {}

uint64_t RingReader::published() const {
  return atomic_word(*published_).load(std::memory_order_acquire);
}

RingReader::Outcome RingReader::read(uint64_t number, std::vector<std::byte>& message, uint64_t& tag) const {
  SlotHeader& slot = slot_at(slots_, stride_, mask_, number);
  if (atomic_word(slot.sequence).load(std::memory_order_acquire) != 2 * number) return Outcome::lapped;
  const uint64_t bytes = atomic_word(slot.bytes).load(relaxed);
  tag = atomic_word(slot.tag).load(relaxed);
  const bool fits = bytes <= capacity_;
  if (fits) {
    message.resize(bytes);
    load_words(message.data(), payload_of(slot), bytes);
  }
  std::atomic_thread_fence(std::memory_order_acquire);
  if (atomic_word(slot.sequence).load(relaxed) != 2 * number) return Outcome::lapped;
  return fits ? Outcome::ok : Outcome::corrupt;
}

}  // namespace fire3dv::transport::shm
