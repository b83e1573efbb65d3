#include "protocol/transport/shm/shm_reply.h"

#include <algorithm>
#include <cstring>

namespace fire3dv::transport::shm {
namespace {

constexpr auto relaxed = std::memory_order_relaxed;

uint64_t words_for(uint64_t bytes) {
  return 1 + (bytes + 7) / 8;
}

std::atomic_ref<uint64_t> word_at(ReaderSlot& slot, uint64_t position) {
  return atomic_word(slot.words[position % kReplyWords]);
}

}  // namespace

ReplyProducer::ReplyProducer(ReaderSlot& slot) : slot_(&slot), head_(atomic_word(slot.head).load(relaxed)) {}

bool ReplyProducer::push(std::span<const std::byte> message) {
  if (slot_ == nullptr || message.size() > kReplyWords * 8) return false;
  const uint64_t needed = words_for(message.size());
  if (!has_room(needed)) return false;
  word_at(*slot_, head_).store(kReplyMark << 32 | message.size(), relaxed);
  for (uint64_t i = 1; i < needed; ++i) {
    const size_t at = (i - 1) * 8;
    uint64_t word = 0;
    std::memcpy(&word, message.data() + at, std::min<size_t>(8, message.size() - at));
    word_at(*slot_, head_ + i).store(word, relaxed);
  }
  head_ += needed;
  atomic_word(slot_->head).store(head_, std::memory_order_release);
  return true;
}

bool ReplyProducer::has_room(uint64_t words) const {
  const uint64_t used = head_ - atomic_word(slot_->tail).load(std::memory_order_acquire);
  return used <= kReplyWords && words <= kReplyWords - used;
}

bool ReplyProducer::push(const ImageNotification& notice) {
  if (!has_room_for_notice()) return false;
  word_at(*slot_, head_).store(kImageMark << 32 | notice.slot, relaxed);
  word_at(*slot_, head_ + 1).store(notice.ticket, relaxed);
  head_ += kNoticeWords;
  atomic_word(slot_->head).store(head_, std::memory_order_release);
  return true;
}

ReplyConsumer::Outcome ReplyConsumer::pop(std::vector<std::byte>& message, ImageNotification& notice) {
  const uint64_t head = atomic_word(slot_->head).load(std::memory_order_acquire);
  const uint64_t available = head - tail_;
  if (available == 0) return Outcome::empty;
  const uint64_t first = available <= kReplyWords ? word_at(*slot_, tail_).load(relaxed) : 0;
  if (first >> 32 == kImageMark && available >= 2) {
    notice = {static_cast<uint32_t>(first), word_at(*slot_, tail_ + 1).load(relaxed)};
    tail_ += 2;
    atomic_word(slot_->tail).store(tail_, std::memory_order_release);
    return Outcome::image;
  }
  const uint64_t bytes = first & UINT32_MAX;
  const uint64_t needed = words_for(bytes);
  const bool sound = first >> 32 == kReplyMark && needed <= available;
  if (sound) {
    message.resize(bytes);
    for (uint64_t i = 1; i < needed; ++i) {
      const size_t at = (i - 1) * 8;
      const uint64_t word = word_at(*slot_, tail_ + i).load(relaxed);
      std::memcpy(message.data() + at, &word, std::min<size_t>(8, message.size() - at));
    }
    tail_ += needed;
  } else {
    tail_ = head;
  }
  atomic_word(slot_->tail).store(tail_, std::memory_order_release);
  return sound ? Outcome::message : Outcome::corrupt;
}

}  // namespace fire3dv::transport::shm
