// Cookies: a listener's way to learn that an address really sends, without remembering anything about it. A
// cookie is a keyed hash of the address, the publisher's nonce and the time; only who receives it can send it
// back.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "protocol/transport/core/address.h"

namespace fire3dv::transport::udp {

class Cookies {
 public:
  Cookies();
  uint64_t make(const Address& address, uint64_t nonce, int64_t now_ns) const;
  // Good for 8 to 16 seconds.
  bool check(uint64_t cookie, const Address& address, uint64_t nonce, int64_t now_ns) const;

 private:
  uint64_t of_period(const Address& address, uint64_t nonce, uint64_t period) const;
  std::array<uint64_t, 2> key_;
};

// SipHash-2-4 (Aumasson and Bernstein, 2012).
uint64_t siphash(const std::array<uint64_t, 2>& key, std::span<const std::byte> message);

}  // namespace fire3dv::transport::udp
