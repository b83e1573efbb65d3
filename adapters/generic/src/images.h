// Registry of a stream's image requests: open requests, arrived images, refusals. Used on the stream's
// thread; errors leave the registry unchanged.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
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
    bool is_batch = false;
  };

  // Sends the request with a new id and slot. On error nothing changes.
  Result<uint64_t> request(transport::PublisherLink& link, wire::ImageRequest request);
  Result<void> cancel(transport::PublisherLink& link, uint64_t epoch, uint64_t id);
  // Sends periodic requests again for a new epoch and ends the others with a refusal.
  Result<void> restart_epoch(transport::PublisherLink& link, uint64_t epoch);

  // Receives images until one of request `id` (0: of any request) has arrived or the link is empty. Drops
  // what is no answer to its request. Batches are only returned by their id. newest_sequence: the last
  // published frame.
  void collect(transport::PublisherLink& link, uint64_t epoch, uint64_t newest_sequence, uint64_t id);
  std::optional<Arrived> take(uint64_t id);
  void on(const wire::ImageRefused& refused);
  // Returns and removes the reason why request `id` (0: any request) has no image.
  std::optional<std::string> take_refusal(uint64_t id);

  bool is_open(uint64_t id) const { return open_.contains(id); }
  bool has_arrived(uint64_t id) const;
  // Requests other than batches.
  bool has_open_singles() const;
  // Images that were dropped, since they are malformed or no answer to their request.
  uint64_t dropped() const { return dropped_; }
  // How many, and why the last one was; empty if there is none. One clause.
  std::string dropped_text() const;

 private:
  struct Open {
    wire::ImageRequest request;
    size_t block_bytes = 0;  // upper bound
    uint64_t last_number = 0, last_sequence = 0;
    bool has_come = false;
    uint64_t lost = 0;  // since the last image taken
  };
  Result<void> send(transport::PublisherLink& link, const wire::ImageRequest& request);
  void close(std::map<uint64_t, Open>::iterator open);
  void refuse(uint64_t id, bool is_batch, std::string why);
  Result<void> arrived(uint64_t epoch, uint64_t newest_sequence, transport::PublisherLink::Image&& image);
  void store(const wire::ImageFrame& frame, std::span<const std::byte> pixels,
             transport::PublisherLink::Image&& keep);

  std::map<uint64_t, Open> open_;  // by id
  std::vector<uint32_t> free_slots_;
  uint32_t next_slot_ = 0;
  uint64_t last_id_ = 0;
  std::optional<size_t> max_block_bytes_ = 0;  // maximum over open_; empty: recompute
  size_t max_block_bytes();
  void bound_arrived();
  void copy_lent_images();

  std::deque<Arrived> arrived_;                  // at most one per request, the newest
  size_t most_open_ = 0, most_block_bytes_ = 0;  // that the link has made room for
  struct Refusal {
    std::string why;
    bool is_batch = false;
  };
  std::map<uint64_t, Refusal> refused_;
  uint64_t dropped_ = 0;
  std::string dropped_why_;  // of the last one
  wire::Decoder decoder_;
};

}  // namespace fire3dv::client
