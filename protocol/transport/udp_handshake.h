// The four datagrams before a session: hello, cookie, hello with the cookie, accept. Protocol in
// SPEC-transport.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "protocol/transport/byte_order.h"
#include "protocol/transport/udp_datagram.h"

namespace fire3dv::transport::udp {

using Hello = std::array<std::byte, kHelloBytes>;
inline Hello write_hello(uint64_t nonce, uint64_t cookie) {
  Hello bytes{};
  write_header(bytes.data(), {kTransportVersion, Type::hello, nonce, 0});
  put_le<uint64_t>(&bytes[kHeaderBytes], cookie);
  return bytes;
}

// cookie and accept carry one number, refuse two short ones; all have this length.
using Answer = std::array<std::byte, kHeaderBytes + 8>;
static_assert(sizeof(Answer) <= kHelloBytes, "an answer must not be longer than the question");
inline Answer write_answer(Type type, uint64_t nonce, uint64_t number) {
  Answer bytes{};
  write_header(bytes.data(), {kTransportVersion, type, nonce, 0});
  put_le<uint64_t>(&bytes[kHeaderBytes], number);
  return bytes;
}
inline std::optional<uint64_t> read_number(std::span<const std::byte> payload) {
  if (payload.size() < 8) return {};
  return get_le<uint64_t>(payload.data());
}

}  // namespace fire3dv::transport::udp
