#include "protocol/transport/udp/dtls/udp_acceptor.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <new>
#include <utility>

#include "protocol/base/clock.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kMaxHandshakeNs = 10 * kSecondNs;
// After the ClientHello a handshake has one flight of three datagrams, which may be repeated. OpenSSL
// allocates 17 KB for each sealed record that arrives too early.
constexpr int kMaxDatagrams = 32, kMaxSealed = 8;

// Subtracts its lifetime from a time budget.
class Spend {
 public:
  explicit Spend(int64_t& left) : left_(left) {}
  ~Spend() { left_ -= monotonic_ns() - began_ns_; }
  Spend(const Spend&) = delete;
  Spend& operator=(const Spend&) = delete;

 private:
  int64_t& left_;
  const int64_t began_ns_ = monotonic_ns();
};

}  // namespace

Acceptor::Outcome Acceptor::client_hello(const Address& from, const RecordDatagram& about,
                                         std::span<const std::byte> datagram, int64_t now_ns) {
  const auto known = pending_.find(from);
  if (known != pending_.end() && known->second.nonce == about.nonce)
    return Outcome::taken;  // tick() repeats the answer
  if (about.has_cookie && begin_ns_left_ <= 0) return Outcome::busy;
  if (!listening_) listening_ = key_->listen();
  if (!listening_) throw std::bad_alloc();
  const Dtls::Cookies cookies{
      [&] { return cookies_.make(from, about.nonce, now_ns); },
      [&](uint64_t cookie) { return cookies_.check(cookie, from, about.nonce, now_ns); }};
  if (!listening_->check_client_hello(datagram, cookies)) {
    const auto answers = listening_->take_outgoing();
    for (const auto& answer : answers) events_.send(from, answer);
    return answers.empty() ? Outcome::malformed : Outcome::taken;
  }
  // The cookie proves that the address is not spoofed.
  const Spend spend(begin_ns_left_);
  if (known == pending_.end() && pending_.size() >= max_pending_) make_room();
  pending_[from] = Pending{std::move(listening_), about.nonce, now_ns, 0};
  const auto at = pending_.find(from);
  progress(at, at->second.dtls->handshake({}));
  return Outcome::taken;
}

Acceptor::Outcome Acceptor::handshake(const Address& from, const RecordDatagram& about,
                                      std::span<const std::byte> datagram) {
  const auto at = pending_.find(from);
  if (at == pending_.end()) return Outcome::malformed;
  if (finish_ns_left_ <= 0) return Outcome::busy;
  Pending& pending = at->second;
  const Spend spend(finish_ns_left_);
  pending.sealed += about.has_sealed;
  if (++pending.datagrams > kMaxDatagrams || pending.sealed > kMaxSealed) {
    pending_.erase(at);
    events_.silent();
    return Outcome::taken;
  }
  if (pending.dtls->established()) {
    pending.dtls->receive_handshake(datagram);
    progress(at, pending.dtls->broken() ? Dtls::Progress::failed : Dtls::Progress::established);
  } else {
    progress(at, pending.dtls->handshake(datagram));
  }
  return Outcome::taken;
}

void Acceptor::progress(PendingMap::iterator at, Dtls::Progress progress) {
  for (const auto& answer : at->second.dtls->take_outgoing()) events_.send(at->first, answer);
  if (progress != Dtls::Progress::failed) return;
  const Pending failed = std::move(at->second);
  const Address from = at->first;
  pending_.erase(at);
  events_.failed(from, failed.nonce, failed.dtls->refusal());
}

void Acceptor::tick(int64_t now_ns) {
  begin_ns_left_ = kMaxBeginNs;
  finish_ns_left_ = kMaxFinishNs;
  for (auto at = pending_.begin(); at != pending_.end();) {
    const auto next = std::next(at);
    Pending& pending = at->second;
    if (now_ns - pending.began_ns > kMaxHandshakeNs ||
        pending.dtls->repeat_flight() == Dtls::Progress::failed) {
      pending_.erase(at);
      events_.silent();
    } else {
      for (const auto& answer : pending.dtls->take_outgoing()) events_.send(at->first, answer);
    }
    at = next;
  }
}

// Drops the oldest handshake of the host that has most of them, so that a flood displaces only its own.
void Acceptor::make_room() {
  const auto of_host = [&](const Address& address) {
    return std::count_if(pending_.begin(), pending_.end(),
                         [&](const auto& other) { return other.first.is_same_host(address); });
  };
  auto victim = pending_.end();
  std::ptrdiff_t most = 0;
  for (auto at = pending_.begin(); at != pending_.end(); ++at) {
    const std::ptrdiff_t count = of_host(at->first);
    if (count < most || (count == most && at->second.began_ns >= victim->second.began_ns)) continue;
    victim = at;
    most = count;
  }
  if (victim == pending_.end()) return;
  pending_.erase(victim);
  events_.silent();
}

Dtls* Acceptor::established(const Address& from) {
  const auto at = pending_.find(from);
  return at != pending_.end() && at->second.dtls->established() ? at->second.dtls.get() : nullptr;
}

Acceptor::Established Acceptor::extract(const Address& from) {
  const auto at = pending_.find(from);
  if (at == pending_.end()) return {};
  Established established{std::move(at->second.dtls), at->second.nonce};
  pending_.erase(at);
  return established;
}

}  // namespace fire3dv::transport::udp
