// Pending DTLS handshakes of a sealed udp:// listener. An address costs no memory before it has returned a
// cookie; after that, number and duration of handshakes are bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>

#include "protocol/base/clock.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/udp/dtls/udp_dtls.h"
#include "protocol/transport/udp/udp_handshake.h"

namespace fire3dv::transport::udp {

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
