#include "protocol/transport/shm_ring.h"

#include "protocol/error.h"
#include "protocol/transport/shm_copy.h"

// The order of accesses follows H.-J. Boehm, "Can Seqlocks Get Along with Programming Language Memory
// Models?" (MSPC 2012): fences stand between the sequence and the payload, and a torn read is thrown away.
// How the payload is copied without being a data race: shm_copy.h.

namespace fire3dv::transport::shm {
namespace {

constexpr auto relaxed = std::memory_order_relaxed;

SlotHeader& slot_at(std::byte* slots, size_t stride, uint64_t mask, uint64_t number) {
  return *reinterpret_cast<SlotHeader*>(slots + ((number - 1) & mask) * stride);
}
std::byte* payload_of(SlotHeader& slot) {
  return reinterpret_cast<std::byte*>(&slot) + kSlotHeaderBytes;
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
  copy_to_shared(payload_of(slot), message.head.data(), message.head.size());
  copy_to_shared(payload_of(slot) + message.head.size(), message.body.data(), message.body.size());
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
    copy_from_shared(message.data(), payload_of(slot), bytes);
  }
  std::atomic_thread_fence(std::memory_order_acquire);
  if (atomic_word(slot.sequence).load(relaxed) != 2 * number) return Outcome::lapped;
  return fits ? Outcome::ok : Outcome::corrupt;
}

}  // namespace fire3dv::transport::shm
