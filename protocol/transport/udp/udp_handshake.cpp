#include "protocol/transport/udp/udp_handshake.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <new>
#include <utility>

#include "base/random.h"
#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kPeriodNs = 8 * kSecondNs;

struct SipState {
  uint64_t v0, v1, v2, v3;

  void rounds(int count) {
    for (int i = 0; i < count; ++i) {
      v0 += v1;
      v2 += v3;
      v1 = std::rotl(v1, 13) ^ v0;
      v3 = std::rotl(v3, 16) ^ v2;
      v0 = std::rotl(v0, 32);
      v2 += v1;
      v0 += v3;
      v1 = std::rotl(v1, 17) ^ v2;
      v3 = std::rotl(v3, 21) ^ v0;
      v2 = std::rotl(v2, 32);
    }
  }
  void absorb(uint64_t word) {
    v3 ^= word;
    rounds(2);
    v0 ^= word;
  }
};

}  // namespace

uint64_t siphash(const std::array<uint64_t, 2>& key, std::span<const std::byte> message) {
  SipState state{key[0] ^ 0x736f6d6570736575, key[1] ^ 0x646f72616e646f6d, key[0] ^ 0x6c7967656e657261,
                 key[1] ^ 0x7465646279746573};
  const size_t whole = message.size() / 8 * 8;
  for (size_t i = 0; i < whole; i += 8) state.absorb(get_le<uint64_t>(&message[i]));
  uint64_t last = static_cast<uint64_t>(message.size() & 0xff) << 56;
  for (size_t i = whole; i < message.size(); ++i)
    last |= static_cast<uint64_t>(message[i]) << (8 * (i - whole));
  state.absorb(last);
  state.v2 ^= 0xff;
  state.rounds(4);
  return state.v0 ^ state.v1 ^ state.v2 ^ state.v3;
}

Cookies::Cookies() : key_{random_id(), random_id()} {}

uint64_t Cookies::of_period(const Address& address, uint64_t nonce, uint64_t period) const {
  const std::string from = address.text();
  std::vector<std::byte> message(16 + from.size());
  put_le<uint64_t>(&message[0], nonce);
  put_le<uint64_t>(&message[8], period);
  std::memcpy(&message[16], from.data(), from.size());
  const uint64_t cookie = siphash(key_, message);
  return cookie != 0 ? cookie : 1;  // 0 means "none yet"
}

uint64_t Cookies::make(const Address& address, uint64_t nonce, int64_t now_ns) const {
  return of_period(address, nonce, static_cast<uint64_t>(now_ns / kPeriodNs));
}

bool Cookies::check(uint64_t cookie, const Address& address, uint64_t nonce, int64_t now_ns) const {
  const auto period = static_cast<uint64_t>(now_ns / kPeriodNs);
  return cookie == of_period(address, nonce, period) || cookie == of_period(address, nonce, period - 1);
}

namespace {

constexpr size_t kModeAt = kHeaderBytes + 8;
constexpr size_t kDatagramBytesAt = kHeaderBytes + 10;
constexpr size_t kAcceptMoreAt = kHeaderBytes + 8;
constexpr size_t kAcceptDatagramBytes = 8;  // the length and zeros, only when the hello named one
static_assert(kAcceptMoreAt + kAcceptDatagramBytes <= kHelloBytes,
              "an answer must not be longer than the request");

}  // namespace

Hello write_hello(uint64_t nonce, uint64_t cookie, uint16_t datagram_bytes) {
  Hello bytes{};
  write_header(bytes.data(), {kTransportVersion, Type::hello, nonce, 0});
  put_le<uint64_t>(&bytes[kHeaderBytes], cookie);
  put_le<uint16_t>(&bytes[kDatagramBytesAt], datagram_bytes);
  return bytes;
}

HelloFields read_hello(std::span<const std::byte> datagram) {
  HelloFields fields;
  fields.cookie = get_le<uint64_t>(&datagram[kHeaderBytes]);
  fields.mode = std::to_integer<uint8_t>(datagram[kModeAt]);
  fields.datagram_bytes = get_le<uint16_t>(&datagram[kDatagramBytesAt]);
  return fields;
}

Answer write_answer(Type type, uint64_t nonce, uint64_t number) {
  Answer bytes{};
  write_header(bytes.data(), {kTransportVersion, type, nonce, 0});
  put_le<uint64_t>(&bytes[kHeaderBytes], number);
  return bytes;
}

std::optional<uint64_t> read_number(std::span<const std::byte> payload) {
  if (payload.size() < 8) return {};
  return get_le<uint64_t>(payload.data());
}

std::vector<std::byte> write_accept(uint64_t nonce, uint64_t session, uint16_t datagram_bytes) {
  const Answer answer = write_answer(Type::accept, nonce, session);
  std::vector<std::byte> bytes(answer.begin(), answer.end());
  if (datagram_bytes == 0) return bytes;
  bytes.resize(bytes.size() + kAcceptDatagramBytes);
  put_le<uint16_t>(&bytes[kAcceptMoreAt], datagram_bytes);
  return bytes;
}

std::optional<AcceptFields> read_accept(std::span<const std::byte> datagram, uint16_t datagram_bytes) {
  const auto session = read_number(datagram.subspan(kHeaderBytes));
  if (!session) return {};
  AcceptFields fields;
  fields.session = *session;
  fields.knows_datagram_bytes =
      datagram_bytes == 0 || (datagram.size() == kAcceptMoreAt + kAcceptDatagramBytes &&
                              get_le<uint16_t>(&datagram[kAcceptMoreAt]) == datagram_bytes);
  return fields;
}

Parameters read_parameters(uint64_t number) {
  return {static_cast<uint8_t>(number), static_cast<uint8_t>(number >> 8),
          static_cast<uint16_t>(number >> 16)};
}

std::vector<std::byte> seal_number(Dtls& dtls, Type type, uint64_t number) {
  constexpr size_t kPlaintextBytes = 9;
  std::vector<std::byte> datagram(kPlaintextBytes + kRecordOverheadBytes);
  datagram[0] = static_cast<std::byte>(type);
  put_le<uint64_t>(&datagram[1], number);
  datagram.resize(dtls.seal(datagram, 0, kPlaintextBytes));
  return datagram;
}

std::optional<SealedNumber> open_number(Dtls& dtls, const RecordDatagram& about,
                                        std::span<std::byte> datagram) {
  std::span<const std::byte> plaintext;
  if (dtls.open(datagram, about.record_number, plaintext) != Dtls::Opened::plaintext || plaintext.empty())
    return {};
  const auto number = read_number(plaintext.subspan(1));
  if (!number) return {};
  return SealedNumber{static_cast<Type>(plaintext[0]), *number};
}

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
