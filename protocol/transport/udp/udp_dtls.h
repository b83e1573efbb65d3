// DTLS 1.2 with a pre-shared key (PSK) over datagrams that the caller transports; no call blocks. The PSK
// authenticates both sides; each session derives its own keys from an ephemeral X25519 exchange.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/core/secret.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/transport/udp/udp_record.h"

struct ssl_ctx_st;
struct ssl_st;

namespace fire3dv::transport::udp {

class Dtls;

class PreSharedKey : public std::enable_shared_from_this<PreSharedKey> {
 public:
  using Key = std::array<unsigned char, 32>;

  // Null without a path. The error names the link.
  static Result<std::shared_ptr<const PreSharedKey>> from_file(const std::string& path, const Uri& uri);
  static Result<std::shared_ptr<const PreSharedKey>> from_secret(const Secret& secret);
  // For tests: any key under any identity.
  static Result<std::shared_ptr<const PreSharedKey>> create(const Key& key, const std::string& identity);
  ~PreSharedKey();
  PreSharedKey(const PreSharedKey&) = delete;
  PreSharedKey& operator=(const PreSharedKey&) = delete;

  // Creates one side of a new handshake. Returns null if out of memory.
  std::unique_ptr<Dtls> connect() const;
  std::unique_ptr<Dtls> listen() const;

  const Key& key() const { return key_; }
  // PSK identity, sent in plaintext: protocol, version, mode and a hash of the key.
  const std::string& identity() const { return identity_; }

 private:
  PreSharedKey(const Key& key, std::string identity) : key_(key), identity_(std::move(identity)) {}

  Key key_;
  std::string identity_;
  std::shared_ptr<ssl_ctx_st> context_;
};

// One side of one session. Not thread-safe.
class Dtls {
 public:
  ~Dtls();
  Dtls(const Dtls&) = delete;
  Dtls& operator=(const Dtls&) = delete;

  // --- handshake; each call may produce datagrams for take_outgoing()

  // Listener: checks the cookie of a ClientHello without creating state. Returns true if it is valid and the
  // handshake may begin; otherwise a HelloVerifyRequest may be ready to be sent.
  struct Cookies {
    std::function<uint64_t()> make;
    std::function<bool(uint64_t)> check;
  };
  bool check_client_hello(std::span<const std::byte> client_hello, const Cookies& cookies);
  // Continues the handshake with a received datagram; an empty one starts it.
  enum class Progress { pending, established, failed };
  Progress handshake(std::span<const std::byte> datagram);
  // Retransmits the last flight if its timeout has expired. timeout_ns() is the time left until then.
  Progress repeat_flight();
  int64_t timeout_ns() const;
  std::vector<std::vector<std::byte>> take_outgoing() { return std::exchange(ends_.outgoing, {}); }

  bool established() const { return established_; }
  // First eight bytes of the client's random. Plaintext answers repeat them, so that an off-path attacker
  // cannot forge one.
  uint64_t nonce() const;
  // Listener: set if the handshake failed because of the publisher's key.
  std::optional<Refusal> refusal() const { return refusal_; }

  // --- session

  // Encrypts `bytes` of plaintext at `plaintext_at` in `datagram` in place. Returns the length of the record,
  // or 0 if the session is broken.
  size_t seal(std::span<std::byte> datagram, size_t plaintext_at, size_t bytes);
  // Decrypts one record in place. repeated: duplicate, or older than the replay window. A forged record does
  // not change the session.
  enum class Opened { plaintext, repeated, forged };
  Opened open(std::span<std::byte> datagram, uint64_t record_number, std::span<const std::byte>& plaintext);
  // Processes a handshake message within a session: the other side may have missed our last flight.
  void receive_handshake(std::span<const std::byte> datagram);
  // OpenSSL has closed the session; nothing can be sealed any more.
  bool broken() const { return broken_; }

 private:
  friend class PreSharedKey;
  friend struct DtlsCallbacks;
  explicit Dtls(std::shared_ptr<const PreSharedKey> key) : key_(std::move(key)) {}
  Progress finish(int outcome);

  const std::shared_ptr<const PreSharedKey> key_;
  ssl_st* ssl_ = nullptr;
  DatagramEnds ends_;
  const Cookies* cookies_ = nullptr;  // during check_client_hello()
  std::optional<Refusal> refusal_;
  bool has_valid_cookie_ = false;
  bool established_ = false;
  bool broken_ = false;
  // Copy of OpenSSL's replay window, because OpenSSL does not report why it dropped a record.
  uint64_t newest_record_ = 0;
  uint64_t seen_records_ = 0;  // bit i: newest_record_ - i was received
};

}  // namespace fire3dv::transport::udp
