// Handshakes of udp:// links: their messages, and the pending ones of a sealed listener. Plaintext: hello,
// cookie, hello with the cookie, accept. Sealed, after the DTLS handshake: hello, accept. See
// SPEC-transport.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/clock.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/transport/udp/udp_dtls.h"

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

// Pending DTLS handshakes of a sealed udp:// listener. An address costs no memory before it has returned a
// cookie; after that, number and duration of handshakes are bounded.
class Acceptor {
 public:
  struct Events {
    std::function<void(const Address& to, std::span<const std::byte> datagram)> send;
    // A handshake failed; `refusal` is set if the publisher's key is the reason.
    std::function<void(const Address& from, uint64_t nonce, std::optional<Refusal> refusal)> failed;
    std::function<void()> silent;  // a handshake timed out
  };
  Acceptor(std::shared_ptr<const PreSharedKey> key, size_t max_pending, Events events)
      : key_(std::move(key)), max_pending_(max_pending), events_(std::move(events)) {}

  // busy: the time budget of this tick is spent; the publisher repeats the datagram.
  enum class Outcome { taken, malformed, busy };
  Outcome client_hello(const Address& from, const RecordDatagram& about, std::span<const std::byte> datagram,
                       int64_t now_ns);
  // Requires has(from).
  Outcome handshake(const Address& from, const RecordDatagram& about, std::span<const std::byte> datagram);
  // Call every 10 ms: repeats flights and ends handshakes that time out.
  void tick(int64_t now_ns);

  bool has(const Address& from) const { return pending_.contains(from); }
  size_t size() const { return pending_.size(); }
  // The completed handshake of this address, or null.
  Dtls* established(const Address& from);
  struct Established {
    std::unique_ptr<Dtls> dtls;
    uint64_t nonce = 0;
  };
  Established extract(const Address& from);
  void drop(const Address& from) { pending_.erase(from); }

 private:
  struct Pending {
    std::unique_ptr<Dtls> dtls;
    uint64_t nonce = 0;
    int64_t began_ns = 0;
    int datagrams = 0, sealed = 0;
  };
  using PendingMap = std::unordered_map<Address, Pending, AddressHash>;
  void progress(PendingMap::iterator at, Dtls::Progress progress);
  void make_room();

  const std::shared_ptr<const PreSharedKey> key_;
  const size_t max_pending_;
  const Events events_;
  Cookies cookies_;
  std::unique_ptr<Dtls> listening_;  // answers ClientHellos; becomes the handshake of one with a valid cookie
  PendingMap pending_;
  // Time left until the next tick for new and for pending handshakes: established streams must not wait for
  // handshakes of unauthenticated peers.
  static constexpr int64_t kMaxBeginNs = 2 * kMillisecondNs, kMaxFinishNs = 2 * kMillisecondNs;
  int64_t begin_ns_left_ = kMaxBeginNs, finish_ns_left_ = kMaxFinishNs;
};

}  // namespace fire3dv::transport::udp
