// Handshake messages. Plaintext: hello, cookie, hello with the cookie, accept. Sealed, after the DTLS
// handshake: hello, accept. See SPEC-transport.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/transport/core/address.h"
#include "protocol/transport/udp/dtls/udp_dtls.h"
#include "protocol/transport/udp/udp_datagram.h"

namespace fire3dv::transport::udp {

// Stateless cookies that prove that a source address is not spoofed (return routability). A cookie is a keyed
// hash of the address, the publisher's nonce and the time.
class Cookies {
 public:
  Cookies();
  uint64_t make(const Address& address, uint64_t nonce, int64_t now_ns) const;
  // A cookie is valid for 8 to 16 seconds.
  bool check(uint64_t cookie, const Address& address, uint64_t nonce, int64_t now_ns) const;

 private:
  uint64_t of_period(const Address& address, uint64_t nonce, uint64_t period) const;
  std::array<uint64_t, 2> key_;
};

// SipHash-2-4 (Aumasson and Bernstein, 2012).
uint64_t siphash(const std::array<uint64_t, 2>& key, std::span<const std::byte> message);

// --- plaintext

using Hello = std::array<std::byte, kHelloBytes>;
// datagram_bytes 0: the default length.
Hello write_hello(uint64_t nonce, uint64_t cookie, uint16_t datagram_bytes = 0);
struct HelloFields {
  uint64_t cookie = 0;
  uint8_t mode = 0;  // 0: plaintext session; others are refused
  uint16_t datagram_bytes = 0;
};
// The datagram is at least kHelloBytes long.
HelloFields read_hello(std::span<const std::byte> datagram);

// cookie and refuse carry one number.
using Answer = std::array<std::byte, kHeaderBytes + 8>;
Answer write_answer(Type type, uint64_t nonce, uint64_t number);
std::optional<uint64_t> read_number(std::span<const std::byte> payload);
// Number of a refuse message. `more`: the maximum datagram length if that is the reason.
constexpr uint64_t refusal_number(Refusal refusal, uint64_t more = 0) {
  return more << 16 | static_cast<uint64_t>(refusal);
}

// accept contains the session and repeats the hello's datagram length unless that was 0.
std::vector<std::byte> write_accept(uint64_t nonce, uint64_t session, uint16_t datagram_bytes = 0);
struct AcceptFields {
  uint64_t session = 0;
  // False: the listener ignored the hello's datagram length (older version).
  bool knows_datagram_bytes = true;
};
std::optional<AcceptFields> read_accept(std::span<const std::byte> datagram, uint16_t datagram_bytes = 0);

// --- sealed: a message consists of its type and one number

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

// Returns the datagram, empty if the session is broken.
std::vector<std::byte> seal_number(Dtls& dtls, Type type, uint64_t number);
struct SealedNumber {
  Type type{};
  uint64_t number = 0;
};
// Decrypts in place. Returns nothing if decryption fails or the message has no number.
std::optional<SealedNumber> open_number(Dtls& dtls, const RecordDatagram& about,
                                        std::span<std::byte> datagram);

}  // namespace fire3dv::transport::udp
