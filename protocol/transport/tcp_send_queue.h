// Replies and images that wait to be sent to one peer of a TCP listener. The program's thread adds them, the
// listener's thread takes them. All are charged to the peer's budget (Resource::queued_bytes) until they have
// left, so that a peer that does not read takes no other peer's room.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "protocol/base/peer_budget.h"
#include "protocol/transport/image_queue.h"

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
  // A framed reply. Images that wait give way to it. False: too many replies wait, and the connection has to
  // end.
  bool add_reply(std::vector<std::byte>&& framed);
  // Charges an image before it is made. Older images that wait give way, that of the request first. Nothing:
  // it does not fit.
  std::optional<BudgetCharge> charge_image(uint64_t request, size_t bytes);
  // Replaces an older image of the request.
  void add_image(uint64_t request, Bytes&& block);
  // True when the listener's thread has to be woken for what was added.
  bool take_wake();
  // Images that gave way since the last call.
  size_t take_dropped_images();

  // --- the listener's thread
  // The next reply, else the oldest image, else nothing.
  std::optional<Bytes> next();
  // Drops what waits, and all that is added later.
  void close();

 private:
  bool drop_image(std::optional<uint64_t> request);

  const std::shared_ptr<PeerBudget> budget_;
  std::mutex mutex_;  // guards all below
  std::deque<Bytes> replies_;
  size_t reply_bytes_ = 0;
  ImageQueue<Bytes> images_;
  size_t dropped_images_ = 0;
  bool needs_wake_ = true;  // the listener's thread found nothing
  bool is_closed_ = false;
};

}  // namespace fire3dv::transport::tcp
