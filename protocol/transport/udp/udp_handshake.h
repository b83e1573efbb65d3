// The messages before a session. In the open: hello, cookie, hello with the cookie, accept. Sealed, where
// DTLS has done the rest: hello, accept. Protocol in SPEC-transport.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/transport/udp/dtls/udp_dtls.h"
#include "protocol/transport/udp/udp_datagram.h"

namespace fire3dv::transport::udp {

// --- in the open

using Hello = std::array<std::byte, kHelloBytes>;
// datagram_bytes 0: the usual length.
Hello write_hello(uint64_t nonce, uint64_t cookie, uint16_t datagram_bytes = 0);
struct HelloFields {
  uint64_t cookie = 0;
  uint8_t mode = 0;  // 0: sessions in the open are the only ones that begin so
  uint16_t datagram_bytes = 0;
};
// The datagram is at least kHelloBytes long.
HelloFields read_hello(std::span<const std::byte> datagram);

// cookie and refuse carry one number.
using Answer = std::array<std::byte, kHeaderBytes + 8>;
Answer write_answer(Type type, uint64_t nonce, uint64_t number);
std::optional<uint64_t> read_number(std::span<const std::byte> payload);
// The number of a refuse: `more` is the largest length of datagrams, where that is the reason.
constexpr uint64_t refusal_number(Refusal refusal, uint64_t more = 0) {
  return more << 16 | static_cast<uint64_t>(refusal);
}

// accept carries the session, and what the hello said of the length of datagrams unless that was 0.
std::vector<std::byte> write_accept(uint64_t nonce, uint64_t session, uint16_t datagram_bytes = 0);
struct AcceptFields {
  uint64_t session = 0;
  // False: the listener has not read what the hello said of datagrams.
  bool knows_datagram_bytes = true;
};
std::optional<AcceptFields> read_accept(std::span<const std::byte> datagram, uint16_t datagram_bytes = 0);

// --- sealed: a message is its type and one number

struct Parameters {
  uint8_t version = kTransportVersion;
  uint8_t mode = kSealedMode;
  uint16_t datagram_bytes = kDatagramBytes;

  static constexpr uint8_t kSealedMode = 1;
  bool operator==(const Parameters&) const = default;
};
constexpr uint64_t parameters_number(const Parameters& parameters) {
  return uint64_t{parameters.version} | uint64_t{parameters.mode} << 8 |
         uint64_t{parameters.datagram_bytes} << 16;
}
Parameters read_parameters(uint64_t number);

// The datagram; empty when nothing can be sealed any more.
std::vector<std::byte> seal_number(Dtls& dtls, Type type, uint64_t number);
struct SealedNumber {
  Type type{};
  uint64_t number = 0;
};
// Opens it in place. Nothing when it is not a message of one number, or does not open.
std::optional<SealedNumber> open_number(Dtls& dtls, const RecordDatagram& about,
                                        std::span<std::byte> datagram);

}  // namespace fire3dv::transport::udp
