// DTLS 1.2 with a pre-shared key, over datagrams that the caller carries: nothing in here can wait. Who has
// the key may have a session; each session has keys of its own from a fresh X25519 exchange.
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

#include "protocol/base/error.h"
#include "protocol/transport/core/secret.h"
#include "protocol/transport/udp/dtls/udp_datagram_bio.h"
#include "protocol/transport/udp/dtls/udp_record.h"
#include "protocol/transport/udp/udp_datagram.h"

struct ssl_ctx_st;
struct ssl_st;

namespace fire3dv::transport::udp {

class Dtls;

class PreSharedKey : public std::enable_shared_from_this<PreSharedKey> {
 public:
  using Key = std::array<unsigned char, 32>;

  static Result<std::shared_ptr<const PreSharedKey>> from_file(const std::string& path);
  static Result<std::shared_ptr<const PreSharedKey>> from_secret(const Secret& secret);
  // Any key under any name.
  static Result<std::shared_ptr<const PreSharedKey>> create(const Key& key, const std::string& identity);
  ~PreSharedKey();
  PreSharedKey(const PreSharedKey&) = delete;
  PreSharedKey& operator=(const PreSharedKey&) = delete;

  // One end of a handshake that has not begun. Null: no memory.
  std::unique_ptr<Dtls> connect() const;
  std::unique_ptr<Dtls> listen() const;

  const Key& key() const { return key_; }
  // What a publisher says in the open of the key that it has: protocol, version, mode and a hash.
  const std::string& identity() const { return identity_; }

 private:
  PreSharedKey(const Key& key, std::string identity) : key_(key), identity_(std::move(identity)) {}

  Key key_;
  std::string identity_;
  std::shared_ptr<ssl_ctx_st> context_;
};

// One end of one session. Not thread-safe.
class Dtls {
 public:
  ~Dtls();
  Dtls(const Dtls&) = delete;
  Dtls& operator=(const Dtls&) = delete;

  // --- handshake; each call may leave datagrams to be sent

  // Listener, as often as it likes: true when the ClientHello has a good cookie, and the handshake begins.
  // Else nothing has changed but that a cookie may wait to be sent.
  struct Cookies {
    std::function<uint64_t()> make;
    std::function<bool(uint64_t)> check;
  };
  bool greet(std::span<const std::byte> client_hello, const Cookies& cookies);
  // Carries the handshake on by a datagram that came; an empty one begins it.
  enum class Progress { going_on, established, failed };
  Progress handshake(std::span<const std::byte> datagram);
  // Repeats what has not been answered in time. timeout_ns() says how long that is from now.
  Progress repeat_flight();
  int64_t timeout_ns() const;
  std::vector<std::vector<std::byte>> take_outgoing() { return std::exchange(ends_.outgoing, {}); }

  bool established() const { return established_; }
  // The first eight bytes of the client's random: answers in the open repeat it, so that nobody off path can
  // write them.
  uint64_t nonce() const;
  // Listener: why the handshake failed, when it is the publisher's key.
  std::optional<Refusal> refusal() const { return refusal_; }

  // --- session

  // Seals `bytes` of plaintext, which begin at `plaintext` in `datagram`, into the whole of it: the bytes to
  // be sent, or 0 when the session can seal no more.
  size_t seal(std::span<std::byte> datagram, size_t plaintext_at, size_t bytes);
  // Opens one record in place. `repeated`: it came before, or too late to tell. A forged one changes nothing.
  enum class Opened { plaintext, repeated, forged };
  Opened open(std::span<std::byte> datagram, uint64_t record_number, std::span<const std::byte>& plaintext);
  // A handshake message that came in a session: the other side may have missed our last flight.
  void hear_handshake(std::span<const std::byte> datagram);
  // It can seal no more: OpenSSL has given it up.
  bool broken() const { return broken_; }

 private:
  friend class PreSharedKey;
  friend struct DtlsCallbacks;
  explicit Dtls(std::shared_ptr<const PreSharedKey> key) : key_(std::move(key)) {}
  Progress finish(int outcome);

  const std::shared_ptr<const PreSharedKey> key_;
  ssl_st* ssl_ = nullptr;
  DatagramEnds ends_;
  const Cookies* cookies_ = nullptr;  // while greet() runs
  std::optional<Refusal> refusal_;
  bool greeted_ = false;  // its cookie was good
  bool established_ = false;
  bool broken_ = false;
  // OpenSSL does not say why it dropped a record: its own window, once more.
  uint64_t newest_record_ = 0;
  uint64_t seen_records_ = 0;  // bit i: newest_record_ - i came
};

}  // namespace fire3dv::transport::udp
