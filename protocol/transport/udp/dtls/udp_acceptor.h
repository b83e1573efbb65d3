// Handshakes of a sealed udp:// listener that are not over: nothing is kept of an address before it has
// returned a cookie, and after that a bounded number of handshakes, each for a bounded time.
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
#include "protocol/transport/udp/udp_cookie.h"

namespace fire3dv::transport::udp {

class Acceptor {
 public:
  struct Events {
    std::function<void(const Address& to, std::span<const std::byte> datagram)> send;
    // A handshake failed; `refusal` is there when the publisher's key is the reason.
    std::function<void(const Address& from, uint64_t nonce, std::optional<Refusal> refusal)> failed;
    std::function<void()> silent;  // one did not end in time
  };
  Acceptor(std::shared_ptr<const PreSharedKey> key, size_t most_pending, Events events)
      : key_(std::move(key)), most_pending_(most_pending), events_(std::move(events)) {}

  // busy: there was no time for it. It comes again.
  enum class Outcome { taken, malformed, busy };
  Outcome client_hello(const Address& from, const RecordDatagram& about, std::span<const std::byte> datagram,
                       int64_t now_ns);
  // Of an address that has() a handshake.
  Outcome handshake(const Address& from, const RecordDatagram& about, std::span<const std::byte> datagram);
  // Each 10 ms: repeats flights, ends what takes too long.
  void turn(int64_t now_ns);

  bool has(const Address& from) const { return pending_.contains(from); }
  size_t size() const { return pending_.size(); }
  // The handshake at this address, once it is done; null until then.
  Dtls* established(const Address& from);
  struct Taken {
    std::unique_ptr<Dtls> dtls;
    uint64_t nonce = 0;
  };
  Taken take(const Address& from);
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
  const size_t most_pending_;
  const Events events_;
  Cookies cookies_;
  std::unique_ptr<Dtls>
      door_;  // answers ClientHellos without a cookie; becomes the handshake of one that has it
  PendingMap pending_;
  // What may still be spent until the next turn, on handshakes that begin and on those that have begun:
  // streams must not wait for strangers' handshakes.
  static constexpr int64_t kMostBeginNs = 2 * kMillisecondNs, kMostFinishNs = 2 * kMillisecondNs;
  int64_t begin_ns_left_ = kMostBeginNs, finish_ns_left_ = kMostFinishNs;
};

}  // namespace fire3dv::transport::udp
