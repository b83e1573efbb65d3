// The four datagrams before a session: hello, cookie, hello with the cookie, accept. Protocol in
// SPEC-transport.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/transport/udp_seal.h"

namespace fire3dv::transport::udp {

using Hello = std::array<std::byte, kHelloBytes>;
// key null: a session without seals. datagram_bytes 0: the usual length.
Hello write_hello(uint64_t nonce, uint64_t cookie, const Random& random = {},
                  const PreSharedKey* key = nullptr, uint16_t datagram_bytes = 0);
struct HelloFields {
  uint64_t cookie = 0;
  bool sealed = false;
  uint16_t datagram_bytes = 0;
  Random random{};
  Proof proof{};
};
// The datagram is at least kHelloBytes long.
HelloFields read_hello(std::span<const std::byte> datagram);
bool proves_key(std::span<const std::byte> hello, const HelloFields& fields, const PreSharedKey& key);

// cookie and refuse carry one number.
using Answer = std::array<std::byte, kHeaderBytes + 8>;
Answer write_answer(Type type, uint64_t nonce, uint64_t number);
std::optional<uint64_t> read_number(std::span<const std::byte> payload);

// accept carries the session, what the hello said of the length of datagrams unless that was 0, and with a
// key the listener's random and proof, about the hello's random.
std::vector<std::byte> write_accept(uint64_t nonce, uint64_t session, const Random& publishers,
                                    const Random& listeners, const PreSharedKey* key,
                                    uint16_t datagram_bytes = 0);
struct AcceptFields {
  uint64_t session = 0;
  Random random{};
  // False: the listener has not read what the hello said of datagrams.
  bool knows_datagram_bytes = true;
};
// Nothing when it is cut short, or key is given and not proved.
std::optional<AcceptFields> read_accept(std::span<const std::byte> datagram, const Random& publishers,
                                        const PreSharedKey* key, uint16_t datagram_bytes = 0);

}  // namespace fire3dv::transport::udp
