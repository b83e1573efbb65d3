// Opens links by URI.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "protocol/base/peer_budget.h"
#include "protocol/error.h"
#include "protocol/transport/link.h"

namespace fire3dv::transport {

// tls:// links. All files are PEM; keys must be closed to other users.
struct TlsPublisherOptions {
  std::string ca_file;           // whom to trust; empty: the system's certificates
  std::string certificate_file;  // of this publisher, for listeners that ask; may be empty
  std::string key_file;
};
struct TlsListenerOptions {
  std::string certificate_file;
  std::string key_file;
  std::string
      client_ca_file;  // publishers must show a certificate that this one signed; empty: anyone may come
};

struct PublisherOptions {
  size_t max_frame_bytes =
      0;  // shm: size of a ring slot; 0 = from the first frame's node count with room to spare
  uint32_t ring_slots = 8;  // shm
  TlsPublisherOptions tls;
  std::string key_file;  // udp: the pre-shared key (64 hexadecimal digits); empty: neither sealed nor proved
};

struct ListenerOptions {
  Delivery delivery = Delivery::newest;
  bool insecure = false;  // allow tcp and udp listeners on addresses other than loopback
  uint32_t max_peers = 64;
  size_t max_memory_bytes = size_t{1}
                            << 30;  // for messages of all peers together that are not whole, or not polled
  // Budgets of the peers; null: the listener makes a pool of its own with the default limits.
  std::shared_ptr<BudgetPool> budgets;
  TlsListenerOptions tls;
  std::string key_file;  // udp: as the publishers'
};

// Succeeds whether or not a renderer is there: connecting goes on in the background for as long as the link
// lives.
Result<std::unique_ptr<PublisherLink>> open_publisher(std::string_view uri,
                                                      const PublisherOptions& options = {});

// Succeeds whether or not an adapter is there. Fails for a port in use, an address that is not ours, key
// files that others can read, and an address other than loopback without a key (udp), a certificate (tls) or
// `insecure`.
Result<std::unique_ptr<ListenerLink>> open_listener(std::string_view uri,
                                                    const ListenerOptions& options = {});

}  // namespace fire3dv::transport
