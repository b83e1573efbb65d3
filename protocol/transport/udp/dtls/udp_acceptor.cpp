#include "protocol/transport/udp/dtls/udp_acceptor.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <new>
#include <utility>

#include "protocol/base/clock.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kMostHandshakeNs = 10 * kSecondNs;
// A handshake has one flight behind its ClientHello, and each time that is repeated it is three datagrams.
// OpenSSL keeps a buffer of 17 KB for each sealed record that comes too early.
constexpr int kMostDatagrams = 32, kMostSealed = 8;

// Takes the time that it lives for off a budget.
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
    return Outcome::taken;  // turn() repeats the answer
  if (about.has_cookie && begin_ns_left_ <= 0) return Outcome::busy;
  if (!door_) door_ = key_->listen();
  if (!door_) throw std::bad_alloc();
  const Dtls::Cookies cookies{
      [&] { return cookies_.make(from, about.nonce, now_ns); },
      [&](uint64_t cookie) { return cookies_.check(cookie, from, about.nonce, now_ns); }};
  if (!door_->greet(datagram, cookies)) {
    const auto answers = door_->take_outgoing();
    for (const auto& answer : answers) events_.send(from, answer);
    return answers.empty() ? Outcome::malformed : Outcome::taken;
  }
  // From here on the address is known to be real.
  const Spend spend(begin_ns_left_);
  if (known == pending_.end() && pending_.size() >= most_pending_) make_room();
  pending_[from] = Pending{std::move(door_), about.nonce, now_ns, 0};
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
  if (++pending.datagrams > kMostDatagrams || pending.sealed > kMostSealed) {
    pending_.erase(at);
    events_.silent();
    return Outcome::taken;
  }
  if (pending.dtls->established()) {
    pending.dtls->hear_handshake(datagram);
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

void Acceptor::turn(int64_t now_ns) {
  begin_ns_left_ = kMostBeginNs;
  finish_ns_left_ = kMostFinishNs;
  for (auto at = pending_.begin(); at != pending_.end();) {
    const auto next = std::next(at);
    Pending& pending = at->second;
    if (now_ns - pending.began_ns > kMostHandshakeNs ||
        pending.dtls->repeat_flight() == Dtls::Progress::failed) {
      pending_.erase(at);
      events_.silent();
    } else {
      for (const auto& answer : pending.dtls->take_outgoing()) events_.send(at->first, answer);
    }
    at = next;
  }
}

// The oldest handshake of the host that has most of them: who opens many takes places from itself.
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

Acceptor::Taken Acceptor::take(const Address& from) {
  const auto at = pending_.find(from);
  if (at == pending_.end()) return {};
  Taken taken{std::move(at->second.dtls), at->second.nonce};
  pending_.erase(at);
  return taken;
}

}  // namespace fire3dv::transport::udp
