// Opens links by URI.
#pragma once

#include <memory>
#include <string_view>

#include "protocol/error.h"
#include "protocol/transport/link.h"

namespace fire3dv::transport {

struct PublisherOptions {
  size_t max_frame_bytes = 0;  // shm: size of a ring slot; 0 = from the first frame's node count with room to spare
  uint32_t ring_slots = 8;     // shm
};

struct ListenerOptions {
  Delivery delivery = Delivery::newest;
  bool insecure = false;       // allow tcp and udp listeners on addresses other than loopback
  uint32_t max_peers = 64;
};

// Succeeds whether or not a renderer is there: connecting goes on in the background for as long as the link lives.
Result<std::unique_ptr<PublisherLink>> open_publisher(std::string_view uri, const PublisherOptions& options = {});

// Succeeds whether or not an adapter is there. Fails for a port in use, an address that is not ours, and an address
// other than loopback without `insecure`.
Result<std::unique_ptr<ListenerLink>> open_listener(std::string_view uri, const ListenerOptions& options = {});

}  // namespace fire3dv::transport
