// Link URIs: shm://NAME, tcp://HOST:PORT, tls://HOST:PORT, udp://HOST:PORT (IPv6 hosts in brackets). udp://
// accepts options: udp://HOST:PORT?mtu=8952&ttl=4&interface=eth0.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace fire3dv::transport {

struct Uri {
  enum class Scheme { shm, tcp, tls, udp };
  Scheme scheme = Scheme::shm;
  std::string name;   // shm: 1 to 64 characters of [A-Za-z0-9_.-], not starting with a dot
  std::string host;   // other schemes: as written, without brackets
  uint16_t port = 0;  // other schemes: 0 lets a listener choose

  // udp only; 0 or empty: not given.
  uint16_t mtu = 0;       // maximum datagram size in bytes
  uint8_t ttl = 0;        // multicast: time to live
  std::string interface;  // multicast: interface name
  bool operator==(const Uri&) const = default;
};

// The error names the URI, its fault and the valid forms.
Result<Uri> parse_uri(std::string_view text);

}  // namespace fire3dv::transport
