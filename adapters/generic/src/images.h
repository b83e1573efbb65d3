// The images that a stream has asked for: which requests are open, what has come of them, and what was
// refused.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::client {

class Images {
 public:
  struct Arrived {
    wire::ImageFrame frame;
    std::span<const std::byte> pixels;
    transport::PublisherLink::Image keep;
    uint64_t lost = 0;
  };

  // Sends the request; its id and place are chosen here. On error nothing has changed.
  Result<uint64_t> ask(transport::PublisherLink& link, wire::ImageRequest request);
  Result<void> cancel(transport::PublisherLink& link, uint64_t epoch, uint64_t id);
  // A new epoch has begun: what goes on is asked for again.
  Result<void> begin_again(transport::PublisherLink& link, uint64_t epoch);

  // Takes in what has come, until there is something of `id` (0: of any request).
  void collect(transport::PublisherLink& link, uint64_t epoch, uint64_t id);
  std::optional<Arrived> take(uint64_t id);
  void on(const wire::ImageRefused& refused);
  // Why there is no image of `id` (0: of some request), once.
  std::optional<std::string> take_refusal(uint64_t id);

  bool is_open(uint64_t id) const { return open_.contains(id); }
  bool has_arrived(uint64_t id) const;
  bool has_open() const { return !open_.empty(); }

 private:
  struct Open {
    wire::ImageRequest request;
    size_t block_bytes = 0;  // at most
    uint64_t last_number = 0, last_sequence = 0;
    bool has_come = false;
    uint64_t lost = 0;  // since an image was taken
  };
  Result<void> send(transport::PublisherLink& link, const wire::ImageRequest& request);
  void close(std::map<uint64_t, Open>::iterator open);
  void refuse(uint64_t id, std::string why);
  void arrived(const wire::ImageFrame& frame, std::span<const std::byte> pixels,
               transport::PublisherLink::Image&& keep);

  std::map<uint64_t, Open> open_;  // by id
  std::vector<uint32_t> free_places_;
  uint32_t next_place_ = 0;
  uint64_t last_id_ = 0;
  std::optional<size_t> most_block_bytes_ = 0;  // of open_; nothing: to be found anew
  size_t requests_to_make_room_for();
  size_t most_block_bytes();
  void bound_arrived();
  void forget_let_go();

  std::deque<Arrived> arrived_;                  // of each request the newest
  std::vector<std::weak_ptr<const void>> held_;  // what was taken, and may still be looked at
  std::map<uint64_t, std::string> refused_;
  wire::Decoder decoder_;
};

}  // namespace fire3dv::client
