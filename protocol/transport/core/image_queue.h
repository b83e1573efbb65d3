// Bounded queue of images for a slow consumer. Holds the newest image of each request; limits apply to the
// total bytes and the number of images.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

namespace fire3dv::transport {

// Block: any type with size() in bytes.
template <typename Block>
class ImageQueue {
 public:
  ImageQueue(size_t max_bytes, size_t max_images) : max_bytes_(max_bytes), max_images_(max_images) {}
  void raise_limit(size_t max_bytes) { max_bytes_ = std::max(max_bytes_, max_bytes); }

  // Returns the dropped images, including the new one if it alone is too large. Freeing them may take long:
  // the caller does so without its lock.
  std::vector<Block> push(uint64_t request, Block block) {
    std::vector<Block> dropped;
    if (std::optional<Block> older = take(request)) dropped.push_back(std::move(*older));
    bytes_ += block.size();
    waiting_.push_back({request, std::move(block)});
    while (bytes_ > max_bytes_ || waiting_.size() > max_images_) dropped.push_back(pop());
    return dropped;
  }

  // Removes the queued image of a request (at most one).
  std::optional<Block> take(uint64_t request) {
    for (auto entry = waiting_.begin(); entry != waiting_.end(); ++entry) {
      if (entry->request != request) continue;
      bytes_ -= entry->block.size();
      std::optional<Block> taken = std::move(entry->block);
      waiting_.erase(entry);
      return taken;
    }
    return {};
  }

  bool empty() const { return waiting_.empty(); }
  size_t bytes() const { return bytes_; }
  // Removes the oldest image.
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

  size_t max_bytes_;
  const size_t max_images_;
  size_t bytes_ = 0;
  std::deque<Entry> waiting_;
};

}  // namespace fire3dv::transport
