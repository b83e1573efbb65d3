// Reassembly window of numbered frames. Elements (poses, datagrams) of several frames arrive in any order,
// duplicated, or never. The window assigns an element to its frame, detects duplicates and drops the oldest
// open frame when it is full. The caller stores the elements. Not thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace fire3dv {

// Set of element indices. Memory grows with the inserted elements: 32 bytes for each range of 256.
class ElementSet {
 public:
  // Returns false if the set already contained the element.
  bool insert(uint32_t element) {
    const size_t range = element / kRange;
    if (ranges_.size() <= range) ranges_.resize(range + 1);
    if (!ranges_[range]) ranges_[range] = std::make_unique<std::bitset<kRange>>();
    auto bit = (*ranges_[range])[element % kRange];
    if (bit) return false;
    bit = true;
    ++size_;
    return true;
  }
  // Inserts [first, first + count) and returns the number of new elements.
  uint32_t insert_range(uint32_t first, uint32_t count) {
    uint32_t inserted = 0;
    for (uint32_t i = 0; i < count; ++i) inserted += insert(first + i);
    return inserted;
  }
  uint32_t size() const { return size_; }
  // Empties the set and retains its memory for the next frame.
  void clear() {
    for (const auto& range : ranges_)
      if (range) range->reset();
    size_ = 0;
  }

 private:
  static constexpr uint32_t kRange = 256;
  std::vector<std::unique_ptr<std::bitset<kRange>>> ranges_;
  uint32_t size_ = 0;
};

// At most `kCount` open (begun, incomplete) frames. `Frame` has the members `uint64_t sequence` (0: free
// slot) and `void clear()`, which sets the sequence to 0.
template <typename Frame, size_t kCount>
class OpenFrames {
 public:
  Frame* find(uint64_t sequence) { return const_cast<Frame*>(std::as_const(*this).find(sequence)); }
  const Frame* find(uint64_t sequence) const {
    const auto found = std::ranges::find(frames_, sequence, &Frame::sequence);
    return sequence != 0 && found != frames_.end() ? &*found : nullptr;
  }
  // Opens a frame; drops the oldest one if all slots are in use. Returns null if all open frames are newer.
  Frame* open(uint64_t sequence) {
    Frame& oldest = *std::ranges::min_element(frames_, {}, &Frame::sequence);  // a free slot counts as oldest
    if (oldest.sequence > sequence) return nullptr;
    if (oldest.sequence != 0) ++given_up_;
    oldest.clear();
    oldest.sequence = sequence;
    return &oldest;
  }
  // The slot with the lowest sequence (0: free slots first) for which `predicate` holds, or null.
  template <typename Predicate>
  Frame* oldest_where(Predicate predicate) {
    Frame* oldest = nullptr;
    for (Frame& frame : frames_)
      if ((!oldest || frame.sequence < oldest->sequence) && predicate(std::as_const(frame))) oldest = &frame;
    return oldest;
  }
  // Drops an open frame for newer ones.
  void give_up(Frame& frame) {
    ++given_up_;
    frame.clear();
  }
  void close(uint64_t sequence) {
    if (Frame* frame = find(sequence)) frame->clear();
  }
  // Closes all frames up to this sequence. Returns the number of open frames with a lower sequence.
  uint64_t close_up_to(uint64_t sequence) {
    uint64_t older = 0;
    for (Frame& frame : frames_) {
      if (frame.sequence == 0 || frame.sequence > sequence) continue;
      older += frame.sequence < sequence;
      frame.clear();
    }
    return older;
  }
  // Number of frames that open() dropped since the last call.
  uint64_t take_given_up() { return std::exchange(given_up_, 0); }
  size_t size() const {
    return static_cast<size_t>(
        std::ranges::count_if(frames_, [](const Frame& frame) { return frame.sequence != 0; }));
  }

 private:
  std::array<Frame, kCount> frames_;
  uint64_t given_up_ = 0;
};

}  // namespace fire3dv
