// URIs that name a link: shm://NAME, tcp://HOST:PORT, tls://HOST:PORT, udp://HOST:PORT (IPv6 hosts in
// brackets). udp:// may have options: udp://HOST:PORT?mtu=8952&ttl=4&interface=eth0.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/error.h"

namespace fire3dv::transport {

struct Uri {
  enum class Scheme { shm, tcp, tls, udp };
  Scheme scheme = Scheme::shm;
  std::string name;   // shm: 1 to 64 characters of [A-Za-z0-9_.-], not starting with a dot
  std::string host;   // the others: as written, without brackets
  uint16_t port = 0;  // the others: 0 lets a listener choose

  // udp alone; 0 or empty: not given.
  uint16_t mtu = 0;       // bytes of the longest datagram
  uint8_t ttl = 0;        // multicast: routers that it may pass, and one
  std::string interface;  // multicast: by name
  bool operator==(const Uri&) const = default;
};

// The error names the URI, what is wrong with it and which forms there are.
Result<Uri> parse_uri(std::string_view text);

}  // namespace fire3dv::transport
