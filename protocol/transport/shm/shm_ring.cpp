#include "protocol/transport/shm/shm_ring.h"

#include "protocol/base/error.h"
#include "protocol/transport/shm/shm_copy.h"

namespace fire3dv::transport::shm {
namespace {

SlotHeader& slot_at(std::byte* slots, size_t stride, uint64_t mask, uint64_t number) {
  return *reinterpret_cast<SlotHeader*>(slots + ((number - 1) & mask) * stride);
}

// Mapped segment as the Memory of shm_ring_steps.h.
class SlotMemory {
 public:
  SlotMemory(SlotHeader& slot, uint64_t& published) : slot_(slot), published_(published) {}

  void store(RingWord word, uint64_t value, std::memory_order order) { at(word).store(value, order); }
  uint64_t load(RingWord word, std::memory_order order) { return at(word).load(order); }
  void fence(std::memory_order order) { std::atomic_thread_fence(order); }

 protected:
  std::byte* payload() { return reinterpret_cast<std::byte*>(&slot_) + kSlotHeaderBytes; }

 private:
  std::atomic_ref<uint64_t> at(RingWord word) {
    switch (word) {
      case RingWord::sequence:
        return atomic_word(slot_.sequence);
      case RingWord::bytes:
        return atomic_word(slot_.bytes);
      case RingWord::tag:
        return atomic_word(slot_.tag);
      case RingWord::published:
        break;
    }
    return atomic_word(published_);
  }

  SlotHeader& slot_;
  uint64_t& published_;
};

struct WriterMemory : SlotMemory {
  const wire::MessagePieces& message;

  WriterMemory(SlotHeader& slot, uint64_t& published, const wire::MessagePieces& pieces)
      : SlotMemory(slot, published), message(pieces) {}
  void copy_in() {
    copy_to_shared(payload(), message.head.data(), message.head.size());
    copy_to_shared(payload() + message.head.size(), message.body.data(), message.body.size());
  }
};

struct ReaderMemory : SlotMemory {
  std::vector<std::byte>& message;

  ReaderMemory(SlotHeader& slot, uint64_t& published, std::vector<std::byte>& into)
      : SlotMemory(slot, published), message(into) {}
  void copy_out(uint64_t bytes) {
    message.resize(bytes);
    copy_from_shared(message.data(), payload(), bytes);
  }
};

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
  WriterMemory memory(slot_at(slots_, stride_, mask_, number), *published_, message);
  write_steps(memory, number, message.size(), tag);
}

RingReader::RingReader(std::byte* segment, const RingGeometry& geometry, uint64_t& published)
    : slots_(segment + geometry.offset),
      stride_(geometry.stride),
      capacity_(geometry.capacity),
      mask_(geometry.count - 1),
      published_(&published) {}

uint64_t RingReader::published() const {
  SlotMemory memory(slot_at(slots_, stride_, mask_, 1), *published_);
  return published_step(memory);
}

RingReader::Outcome RingReader::read(uint64_t number, std::vector<std::byte>& message, uint64_t& tag) const {
  ReaderMemory memory(slot_at(slots_, stride_, mask_, number), *published_, message);
  return read_steps(memory, number, capacity_, tag);
}

}  // namespace fire3dv::transport::shm
