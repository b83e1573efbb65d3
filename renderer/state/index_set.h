// Bit set of small indices with its size and a revision counter. Every change increments the revision. Not
// thread-safe.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fire3dv::state {

class IndexSet {
 public:
  IndexSet() = default;
  explicit IndexSet(size_t end) : words_((end + 63) / 64) {}  // holds indices below `end`

  void insert(uint32_t index) { change(index, true); }
  void erase(uint32_t index) { change(index, false); }
  bool contains(uint32_t index) const { return (words_[index / 64] >> (index % 64) & 1) != 0; }
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  uint64_t revision() const { return revision_; }
  bool has_same(const IndexSet& other) const { return words_ == other.words_; }
  // Restores the revision after a rebuild that produced the same indices.
  void set_revision(uint64_t revision) { revision_ = revision; }

  // Calls visit(index) in ascending order until it returns false.
  template <typename Visit>
  void visit(Visit&& visit) const {
    for (size_t word = 0; word < words_.size(); ++word) {
      for (uint64_t bits = words_[word]; bits != 0; bits &= bits - 1) {
        if (!visit(static_cast<uint32_t>(word * 64 + static_cast<size_t>(std::countr_zero(bits))))) return;
      }
    }
  }

 private:
  void change(uint32_t index, bool present) {
    if (contains(index) == present) return;
    words_[index / 64] ^= uint64_t{1} << (index % 64);
    size_ = present ? size_ + 1 : size_ - 1;
    ++revision_;
  }

  std::vector<uint64_t> words_;
  size_t size_ = 0;
  uint64_t revision_ = 0;
};

}  // namespace fire3dv::state
