// Back channel over shared memory: a word ring from one reader to the publisher. Each side trusts only its
// own counter.
#pragma once

#include <span>
#include <vector>

#include "protocol/transport/shm/shm_images.h"
#include "protocol/transport/shm/shm_layout.h"

namespace fire3dv::transport::shm {

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
