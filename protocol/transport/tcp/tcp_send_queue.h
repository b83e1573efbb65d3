// Send queue of replies and images for one peer of a TCP listener, filled by the caller's thread and drained
// by the listener's thread. Queued bytes are charged to the peer's budget (Resource::queued_bytes), so that a
// slow peer takes no memory from others.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "protocol/base/peer_budget.h"
#include "protocol/transport/core/image_queue.h"

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
