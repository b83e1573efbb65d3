// Images in shared memory: slots that a reader fills and the publisher looks at where they lie. Each slot has
// one owner at a time, who is named in its first word; SPEC-transport 1.7 says who may change it how. So
// nothing is written while it is read, and nothing is copied.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "protocol/transport/shm_layout.h"

namespace fire3dv::transport::shm {

enum class ImagePhase : uint64_t { free = 0, writing = 1, complete = 2, reading = 3 };

// The first word of a slot. place: of the reader that fills it, in the table of readers.
constexpr uint64_t image_owner(uint64_t ticket, uint32_t place, ImagePhase phase) {
  return ticket << 16 | uint64_t{place + 1} << 8 | static_cast<uint64_t>(phase);
}
constexpr uint64_t kMostTicket = (uint64_t{1} << 48) - 1;

// The reader's end.
class ImageWriter {
 public:
  ImageWriter() = default;
  // Frees what an earlier owner of the place was writing when it died.
  ImageWriter(std::byte* segment, const RingGeometry& geometry, uint32_t place);

  size_t capacity() const { return geometry_.capacity; }

  struct Place {
    uint32_t slot = 0;
    uint64_t ticket = 0;
    std::span<std::byte> block;  // as long as was asked
    bool overtakes = false;      // an older image of the request, which nobody has looked at, is lost by it
  };
  // A slot to be filled; nothing when the publisher has not let go of enough of them.
  std::optional<Place> begin(uint64_t request, size_t bytes);
  // The publisher may have it.
  void complete(const Place& place);
  // Nobody can be told of it after all.
  void give_up(const Place& place);

 private:
  std::atomic_ref<uint64_t> owner(uint32_t slot) const;
  std::optional<uint32_t> take(uint64_t request, bool& overtakes);

  std::byte* slots_ = nullptr;
  RingGeometry geometry_{};
  uint32_t place_ = 0;
  uint64_t ticket_ = 0;
  uint32_t next_slot_ = 0;
  struct Filled {
    uint32_t slot;
    uint64_t ticket;
  };
  std::unordered_map<uint64_t, Filled> newest_of_request_;
};

// What a reader tells the publisher of an image.
struct ImageNotice {
  uint32_t slot = 0;
  uint64_t ticket = 0;
  bool operator==(const ImageNotice&) const = default;
};

// The publisher's end. It believes nothing but its own geometry.
class ImageTaker {
 public:
  ImageTaker() = default;
  ImageTaker(std::byte* segment, const RingGeometry& geometry) : geometry_(geometry) {
    if (geometry.count != 0) slots_ = segment + geometry.offset;
  }

  // False for what no reader of ours can have said.
  bool is_sound(const ImageNotice& notice) const {
    return notice.slot < geometry_.count && notice.ticket <= kMostTicket;
  }
  // Whether the slot still holds that image.
  bool is_there(const ImageNotice& notice, uint32_t place) const;
  // The image's block, from now on untouched until it is let go; nothing when a newer one has its place.
  std::optional<std::span<const std::byte>> take(const ImageNotice& notice, uint32_t place);
  void let_go(uint32_t slot);
  // Readers of which is_alive(place) is false have died: what they were writing will not be completed. What
  // they completed and is_noted(notice, place) is false of, nobody will be told of.
  template <typename IsAlive, typename IsNoted>
  void free_unfinished(IsAlive&& is_alive, IsNoted&& is_noted);

 private:
  std::atomic_ref<uint64_t> owner(uint32_t slot) const;

  std::byte* slots_ = nullptr;
  RingGeometry geometry_{};
};

template <typename IsAlive, typename IsNoted>
void ImageTaker::free_unfinished(IsAlive&& is_alive, IsNoted&& is_noted) {
  for (uint32_t slot = 0; slot < geometry_.count; ++slot) {
    uint64_t word = owner(slot).load(std::memory_order_relaxed);
    const auto phase = static_cast<ImagePhase>(word & 0xff);
    if (phase != ImagePhase::writing && phase != ImagePhase::complete) continue;
    const uint64_t place = (word >> 8 & 0xff) - 1;
    if (place < kReaderCount && is_alive(static_cast<uint32_t>(place))) continue;
    if (phase == ImagePhase::complete && place < kReaderCount &&
        is_noted(ImageNotice{slot, word >> 16}, static_cast<uint32_t>(place)))
      continue;
    owner(slot).compare_exchange_strong(word, 0, std::memory_order_acq_rel);
  }
}

}  // namespace fire3dv::transport::shm
