#include "protocol/transport/shm/shm_back_channel.h"

#include <algorithm>
#include <cstring>

#include "base/clock.h"
#include "base/error.h"

namespace fire3dv::transport::shm {
namespace {

constexpr auto acq_rel = std::memory_order_acq_rel;
constexpr auto release = std::memory_order_release;
constexpr auto relaxed = std::memory_order_relaxed;

ImageSlotHeader& header_of(std::byte* slots, const RingGeometry& geometry, uint32_t slot) {
  return *reinterpret_cast<ImageSlotHeader*>(slots + slot * geometry.stride);
}

std::byte* block_of(std::byte* slots, const RingGeometry& geometry, uint32_t slot) {
  return slots + slot * geometry.stride + kSlotHeaderBytes;
}

uint64_t words_for(uint64_t bytes) {
  return 1 + (bytes + 7) / 8;
}

std::atomic_ref<uint64_t> word_at(ReaderSlot& slot, uint64_t position) {
  return atomic_word(slot.words[position % kReplyWords]);
}

}  // namespace

ImageWriter::ImageWriter(std::byte* segment, const RingGeometry& geometry, uint32_t reader)
    : geometry_(geometry), reader_(reader) {
  if (geometry.count == 0) return;
  slots_ = segment + geometry.offset;
  // Greater than all tickets of earlier owners of this reader slot.
  ticket_ = static_cast<uint64_t>(monotonic_ns()) / 1024 & kMaxTicket / 2;
  for (uint32_t slot = 0; slot < geometry_.count; ++slot) {
    uint64_t word = owner(slot).load(relaxed);
    const uint64_t writing = image_owner(0, reader, ImagePhase::writing);
    if ((word & 0xffff) == writing) owner(slot).compare_exchange_strong(word, 0, acq_rel);
  }
}

std::atomic_ref<uint64_t> ImageWriter::owner(uint32_t slot) const {
  return atomic_word(header_of(slots_, geometry_, slot).owner);
}

std::optional<uint32_t> ImageWriter::take(uint64_t request, bool& overtakes) {
  const uint64_t ours = image_owner(ticket_, reader_, ImagePhase::writing);
  const auto newest = newest_of_request_.find(request);
  if (newest != newest_of_request_.end()) {
    uint64_t word = image_owner(newest->second.ticket, reader_, ImagePhase::complete);
    if (owner(newest->second.slot).compare_exchange_strong(word, ours, acq_rel)) {
      overtakes = true;
      return newest->second.slot;
    }
  }
  for (uint64_t tried = 0; tried < geometry_.count; ++tried) {
    const uint32_t slot = next_slot_;
    next_slot_ = static_cast<uint32_t>((next_slot_ + 1) % geometry_.count);
    uint64_t word = owner(slot).load(relaxed);
    if (word == 0 && owner(slot).compare_exchange_strong(word, ours, acq_rel)) return slot;
  }
  return {};
}

std::optional<ImageWriter::Reservation> ImageWriter::begin(uint64_t request, size_t bytes) {
  if (slots_ == nullptr || bytes > geometry_.capacity) return {};
  Reservation reservation;
  reservation.ticket = ++ticket_;
  const std::optional<uint32_t> slot = take(request, reservation.overtakes);
  if (!slot) return {};
  // Only requests with an image in a slot need an entry.
  if (newest_of_request_.size() >= 2 * geometry_.count) newest_of_request_.clear();
  newest_of_request_[request] = {*slot, reservation.ticket};
  reservation.slot = *slot;
  reservation.block = {block_of(slots_, geometry_, *slot), bytes};
  return reservation;
}

void ImageWriter::complete(const Reservation& reservation) {
  atomic_word(header_of(slots_, geometry_, reservation.slot).bytes).store(reservation.block.size(), relaxed);
  owner(reservation.slot).store(image_owner(reservation.ticket, reader_, ImagePhase::complete), release);
}

void ImageWriter::give_up(const Reservation& reservation) {
  // A complete image may be taken by the publisher concurrently.
  for (const ImagePhase phase : {ImagePhase::writing, ImagePhase::complete}) {
    uint64_t word = image_owner(reservation.ticket, reader_, phase);
    owner(reservation.slot).compare_exchange_strong(word, 0, acq_rel);
  }
}

std::atomic_ref<uint64_t> ImageReader::owner(uint32_t slot) const {
  return atomic_word(header_of(slots_, geometry_, slot).owner);
}

bool ImageReader::is_there(const ImageNotification& notice, uint32_t reader) const {
  return owner(notice.slot).load(relaxed) == image_owner(notice.ticket, reader, ImagePhase::complete);
}

std::optional<std::span<const std::byte>> ImageReader::take(const ImageNotification& notice,
                                                            uint32_t reader) {
  uint64_t word = image_owner(notice.ticket, reader, ImagePhase::complete);
  const uint64_t reading = image_owner(notice.ticket, reader, ImagePhase::reading);
  if (!owner(notice.slot).compare_exchange_strong(word, reading, acq_rel)) return {};
  const uint64_t bytes = atomic_word(header_of(slots_, geometry_, notice.slot).bytes).load(relaxed);
  if (bytes > geometry_.capacity) {
    let_go(notice.slot);
    return {};
  }
  return std::span<const std::byte>(block_of(slots_, geometry_, notice.slot), bytes);
}

void ImageReader::let_go(uint32_t slot) {
  owner(slot).store(0, release);
}

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
