// Images that wait for someone slower than who makes them: of each request the newest, and of all together no
// more than a bound of bytes and of images.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

namespace fire3dv::transport {

// Block: what has a size() in bytes.
template <typename Block>
class ImageQueue {
 public:
  ImageQueue(size_t most_bytes, size_t most_images) : most_bytes_(most_bytes), most_images_(most_images) {}
  void raise(size_t most_bytes) { most_bytes_ = std::max(most_bytes_, most_bytes); }

  // The images that were given up for it, itself among them when it alone is too large. They may be long:
  // whoever holds a lock frees them after it.
  std::vector<Block> push(uint64_t request, Block block) {
    std::vector<Block> given_up;
    if (std::optional<Block> older = take(request)) given_up.push_back(std::move(*older));
    bytes_ += block.size();
    waiting_.push_back({request, std::move(block)});
    while (bytes_ > most_bytes_ || waiting_.size() > most_images_) given_up.push_back(pop());
    return given_up;
  }

  // The image of a request, of which one waits at most.
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

  size_t most_bytes_;
  const size_t most_images_;
  size_t bytes_ = 0;
  std::deque<Entry> waiting_;
};

}  // namespace fire3dv::transport
