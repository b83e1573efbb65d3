// The back channel: a ring of words from one reader to the publisher. Each side believes only its own
// counter.
#pragma once

#include <span>
#include <vector>

#include "protocol/transport/shm_images.h"
#include "protocol/transport/shm_layout.h"

namespace fire3dv::transport::shm {

class ReplyProducer {
 public:
  ReplyProducer() = default;
  // Goes on where an earlier owner of the slot stopped: its head always stands between two messages.
  explicit ReplyProducer(ReaderSlot& slot);

  // False when there is no room.
  bool push(std::span<const std::byte> message);
  bool push(const ImageNotice& notice);
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

  // `corrupt`: what the reader left makes no sense; all of it is skipped.
  // `image`: of an image only `notice` is set.
  Outcome pop(std::vector<std::byte>& message, ImageNotice& notice);
  bool is_empty() const { return atomic_word(slot_->head).load(std::memory_order_acquire) == tail_; }

 private:
  ReaderSlot* slot_ = nullptr;
  uint64_t tail_ = 0;
};

}  // namespace fire3dv::transport::shm
