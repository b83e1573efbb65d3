// Factory functions of links by URI.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/peer_budget.h"
#include "protocol/transport/link.h"

namespace fire3dv::transport {

// TLS options. All files are PEM; key files must not be accessible to other users.
struct TlsPublisherOptions {
  std::string ca_file;           // trusted CAs; empty: the system's certificates
  std::string certificate_file;  // client certificate for listeners that require one; may be empty
  std::string key_file;
};
struct TlsListenerOptions {
  std::string certificate_file;
  std::string key_file;
  std::string client_ca_file;  // CA of the required client certificates; empty: no client certificates
};

struct PublisherOptions {
  size_t max_frame_bytes =
      0;  // shm: size of a ring slot; 0: derived from the first frame's node count, with reserve
  uint32_t ring_slots = 8;  // shm only
  TlsPublisherOptions tls;
  // Udp: pre-shared key (64 hexadecimal digits); empty: no encryption or authentication.
  std::string key_file;
};

struct ListenerOptions {
  Delivery delivery = Delivery::newest;
  bool insecure = false;  // allows tcp and udp listeners on addresses other than loopback
  uint32_t max_peers = 64;
  // Budgets of the peers. Null: the listener creates a pool with the default limits.
  std::shared_ptr<BudgetPool> budgets;
  TlsListenerOptions tls;
  std::string key_file;  // udp: same key as the publishers
  // Called with each pose and control message, and with the end of each peer, when it arrives: independent of
  // polls, of `delivery` and of paused peers. Called on a thread of the link, of several links at the same
  // time. Peers have other numbers than in poll(). Must not block. For recordings.
  OnArrival on_arrival;
};

// Checks the form of an address of a link, without opening it.
Result<void> check_uri(std::string_view uri);

// Opens a publisher. Succeeds without a renderer: the link keeps connecting in the background.
Result<std::unique_ptr<PublisherLink>> open_publisher(std::string_view uri,
                                                      const PublisherOptions& options = {});

// Opens a listener. Succeeds without an adapter. Fails for a port in use, a foreign address, or key files
// readable by others. Addresses other than loopback require a key (udp), a certificate (tls) or `insecure`.
Result<std::unique_ptr<ListenerLink>> open_listener(std::string_view uri,
                                                    const ListenerOptions& options = {});

}  // namespace fire3dv::transport
