// Send queue of replies and images for one peer of a TCP listener, and the image queue in it. It is filled by
// the caller's thread and drained by the listener's thread. Queued bytes are charged to the peer's budget
// (Resource::queued_bytes), so that a slow peer takes no memory from others.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "base/peer_budget.h"

namespace fire3dv::transport {

// Bounded queue of images for a slow consumer. Holds the newest image of each request; limits apply to the
// total bytes and the number of images. Block: any type with size() in bytes.
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

namespace fire3dv::transport::tcp {

class SendQueue {
 public:
  explicit SendQueue(std::shared_ptr<PeerBudget> budget);

  struct Bytes {
    std::vector<std::byte> bytes;
    BudgetCharge charge;
    bool is_image = false;
    size_t size() const { return bytes.size(); }
  };

  // --- the program's thread
  // Queues a framed reply; drops queued images if needed. Returns false if too many replies are queued, and
  // the connection must end.
  bool add_reply(std::vector<std::byte>&& framed);
  // Charges an image before it is rendered; drops older images if needed, that of the request first. Returns
  // nothing if it does not fit.
  std::optional<BudgetCharge> charge_image(uint64_t request, size_t bytes);
  // Queues an image; replaces an older one of the request.
  void add_image(uint64_t request, Bytes&& block);
  // True if the listener's thread must be woken for new items.
  bool take_wake();
  // Number of images dropped since the last call.
  size_t take_dropped_images();

  // --- the listener's thread
  // Returns the next reply, or the oldest image, or nothing.
  std::optional<Bytes> next();
  // Drops all queued and future items.
  void close();

 private:
  bool drop_image(std::optional<uint64_t> request);

  const std::shared_ptr<PeerBudget> budget_;
  std::mutex mutex_;  // guards all members below
  std::deque<Bytes> replies_;
  size_t reply_bytes_ = 0;
  ImageQueue<Bytes> images_;
  size_t dropped_images_ = 0;
  bool needs_wake_ = true;  // the listener's thread found the queue empty
  bool is_closed_ = false;
};

}  // namespace fire3dv::transport::tcp
