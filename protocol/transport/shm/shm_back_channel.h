// Back channel of shared memory, from readers to the publisher: images in slots, and a ring of replies.
//
// Image slots: a reader writes pixels, and the publisher reads them in place. The first word
// of a slot names its single owner; SPEC-transport 1.7 defines the transitions. No slot is written while it
// is read. The reader's copy from its read-back buffer into the slot is the only one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "protocol/transport/shm/shm_layout.h"

namespace fire3dv::transport::shm {

enum class ImagePhase : uint64_t { free = 0, writing = 1, complete = 2, reading = 3 };

// Owner word of a slot. reader: index of the writing reader in the reader table.
constexpr uint64_t image_owner(uint64_t ticket, uint32_t reader, ImagePhase phase) {
  return ticket << 16 | uint64_t{reader + 1} << 8 | static_cast<uint64_t>(phase);
}
constexpr uint64_t kMaxTicket = (uint64_t{1} << 48) - 1;

// Reader side: writes images.
class ImageWriter {
 public:
  ImageWriter() = default;
  // Frees the slots that an earlier owner of the reader slot left unfinished.
  ImageWriter(std::byte* segment, const RingGeometry& geometry, uint32_t reader);

  size_t capacity() const { return geometry_.capacity; }

  struct Reservation {
    uint32_t slot = 0;
    uint64_t ticket = 0;
    std::span<std::byte> block;  // has the requested length
    bool overtakes = false;      // replaces an unread older image of the request
  };
  // Reserves a slot; nothing if the publisher has not released enough of them.
  std::optional<Reservation> begin(uint64_t request, size_t bytes);
  // Passes the slot to the publisher.
  void complete(const Reservation& reservation);
  // Releases the slot if the publisher cannot be notified.
  void give_up(const Reservation& reservation);

 private:
  std::atomic_ref<uint64_t> owner(uint32_t slot) const;
  std::optional<uint32_t> take(uint64_t request, bool& overtakes);

  std::byte* slots_ = nullptr;
  RingGeometry geometry_{};
  uint32_t reader_ = 0;
  uint64_t ticket_ = 0;
  uint32_t next_slot_ = 0;
  struct Filled {
    uint32_t slot;
    uint64_t ticket;
  };
  std::unordered_map<uint64_t, Filled> newest_of_request_;
};

// Notification of a complete image from reader to publisher.
struct ImageNotification {
  uint32_t slot = 0;
  uint64_t ticket = 0;
  bool operator==(const ImageNotification&) const = default;
};

// Publisher side: reads images. Trusts only its own geometry.
class ImageReader {
 public:
  ImageReader() = default;
  ImageReader(std::byte* segment, const RingGeometry& geometry) : geometry_(geometry) {
    if (geometry.count != 0) slots_ = segment + geometry.offset;
  }

  // False for values that no correct reader sends.
  bool is_sound(const ImageNotification& notice) const {
    return notice.slot < geometry_.count && notice.ticket <= kMaxTicket;
  }
  // True if the slot still holds that image.
  bool is_there(const ImageNotification& notice, uint32_t reader) const;
  // Borrows the image's block, unchanged until it is released; nothing if a newer one replaced it.
  std::optional<std::span<const std::byte>> take(const ImageNotification& notice, uint32_t reader);
  void let_go(uint32_t slot);
  // Frees slots of dead readers (is_alive(reader) is false) that are still being written, and their complete
  // images without a notification (is_noted(notice, reader) is false).
  template <typename IsAlive, typename IsNoted>
  void free_unfinished(IsAlive&& is_alive, IsNoted&& is_noted);

 private:
  std::atomic_ref<uint64_t> owner(uint32_t slot) const;

  std::byte* slots_ = nullptr;
  RingGeometry geometry_{};
};

template <typename IsAlive, typename IsNoted>
void ImageReader::free_unfinished(IsAlive&& is_alive, IsNoted&& is_noted) {
  for (uint32_t slot = 0; slot < geometry_.count; ++slot) {
    uint64_t word = owner(slot).load(std::memory_order_relaxed);
    const auto phase = static_cast<ImagePhase>(word & 0xff);
    if (phase != ImagePhase::writing && phase != ImagePhase::complete) continue;
    const uint64_t reader = (word >> 8 & 0xff) - 1;
    if (reader < kReaderCount && is_alive(static_cast<uint32_t>(reader))) continue;
    if (phase == ImagePhase::complete && reader < kReaderCount &&
        is_noted(ImageNotification{slot, word >> 16}, static_cast<uint32_t>(reader)))
      continue;
    owner(slot).compare_exchange_strong(word, 0, std::memory_order_acq_rel);
  }
}

// --- replies: a word ring from one reader to the publisher. Each side trusts only its own counter.

class ReplyProducer {
 public:
  ReplyProducer() = default;
  // Continues at the head of an earlier owner of the slot, which is always a message boundary.
  explicit ReplyProducer(ReaderSlot& slot);

  // Returns false if the ring is full.
  bool push(std::span<const std::byte> message);
  bool push(const ImageNotification& notice);
  bool has_room_for_notice() const { return slot_ != nullptr && has_room(kNoticeWords); }

 private:
  static constexpr uint64_t kNoticeWords = 2;
  bool has_room(uint64_t words) const;

  ReaderSlot* slot_ = nullptr;
  uint64_t head_ = 0;
};

class ReplyConsumer {
 public:
  enum class Outcome { empty, message, image, corrupt };

  ReplyConsumer() = default;
  explicit ReplyConsumer(ReaderSlot& slot) : slot_(&slot) {}

  // corrupt: invalid contents, all skipped. image: only `notice` is set.
  Outcome pop(std::vector<std::byte>& message, ImageNotification& notice);
  bool is_empty() const { return atomic_word(slot_->head).load(std::memory_order_acquire) == tail_; }

 private:
  ReaderSlot* slot_ = nullptr;
  uint64_t tail_ = 0;
};

}  // namespace fire3dv::transport::shm
