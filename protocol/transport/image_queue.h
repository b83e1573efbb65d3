// Images that wait for someone slower than who makes them: of each request the newest, and of all together no
// more than a bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>

namespace fire3dv::transport {

// Block: what has a size() in bytes.
template <typename Block>
class ImageQueue {
 public:
  explicit ImageQueue(size_t most_bytes) : most_bytes_(most_bytes) {}

  // How many images were given up for it, itself among them when it alone is too large.
  size_t push(uint64_t request, Block block) {
    const size_t before = waiting_.size();
    std::erase_if(waiting_, [&](const Entry& entry) {
      if (entry.request == request) bytes_ -= entry.block.size();
      return entry.request == request;
    });
    bytes_ += block.size();
    waiting_.push_back({request, std::move(block)});
    while (bytes_ > most_bytes_) pop_front();
    return before + 1 - waiting_.size();
  }

  bool empty() const { return waiting_.empty(); }
  size_t bytes() const { return bytes_; }
  // The oldest.
  Block pop() {
    Block block = std::move(waiting_.front().block);
    bytes_ -= block.size();
    waiting_.pop_front();
    return block;
  }

 private:
  struct Entry {
    uint64_t request;
    Block block;
  };
  void pop_front() {
    bytes_ -= waiting_.front().block.size();
    waiting_.pop_front();
  }

  const size_t most_bytes_;
  size_t bytes_ = 0;
  std::deque<Entry> waiting_;
};

}  // namespace fire3dv::transport
