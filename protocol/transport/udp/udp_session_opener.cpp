#include "protocol/transport/udp/udp_session_opener.h"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <utility>

#include "base/clock.h"
#include "base/random.h"
#include "protocol/transport/udp/udp_handshake.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kFirstHelloAfterNs = 10 * kMillisecondNs;
constexpr int64_t kLongestHelloAfterNs = kSecondNs;
constexpr int64_t kAddressTimeoutNs = 3 * kSecondNs;

}  // namespace

SessionOpener::SessionOpener(int fd, const Uri& uri, const PreSharedKey* key, size_t datagram_bytes,
                             LinkThread& thread, LinkCounters& counters)
    : fd_(fd), uri_(uri), key_(key), datagram_bytes_(datagram_bytes), thread_(thread), counters_(counters) {}

std::unique_ptr<Session> SessionOpener::open() {
  return key_ != nullptr ? open_sealed() : open_plain();
}

// Returns false if no listener is bound to the address. An empty datagram means timeout.
bool SessionOpener::wait_for_answer(int64_t until_ns, std::span<std::byte>& datagram) {
  datagram = {};
  if (!thread_.wait_for(fd_, POLLIN | POLLERR, until_ns)) return true;
  const ssize_t got = ::recv(fd_, buffer_.data(), buffer_.size(), 0);
  if (got < 0) return errno != ECONNREFUSED;
  datagram = std::span(buffer_).first(static_cast<size_t>(got));
  return true;
}

std::unique_ptr<Session> SessionOpener::open_plain() {
  const uint64_t nonce = random_id();
  uint64_t cookie = 0;
  int64_t wait_ns = kFirstHelloAfterNs;
  const int64_t until = monotonic_ns() + kAddressTimeoutNs;
  const bool is_default = uri_.mtu == 0 && datagram_bytes_ == kDatagramBytes;
  const auto asked_bytes = static_cast<uint16_t>(is_default ? 0 : datagram_bytes_);
  while (!thread_.stopping() && monotonic_ns() < until) {
    const Hello hello = write_hello(nonce, cookie, asked_bytes);
    if (::send(fd_, hello.data(), hello.size(), MSG_NOSIGNAL) < 0 && errno == ECONNREFUSED) return nullptr;
    const int64_t repeat_at = monotonic_ns() + wait_ns;
    wait_ns = std::min(wait_ns * 2, kLongestHelloAfterNs);
    bool answered = false;
    while (!answered && !thread_.stopping() && monotonic_ns() < repeat_at) {
      std::span<std::byte> datagram;
      if (!wait_for_answer(repeat_at, datagram)) return nullptr;
      Header header;
      if (!read_header(datagram, header) || header.session != nonce) continue;
      const auto number = read_number(datagram.subspan(kHeaderBytes));
      if (header.type == Type::refuse || header.version != kTransportVersion) {
        refuse(number.value_or(0), header.version);
        return nullptr;
      }
      if (header.type == Type::cookie && cookie == 0 && number) {
        cookie = *number;
        wait_ns = kFirstHelloAfterNs;
        answered = true;
      }
      if (header.type != Type::accept || cookie == 0) continue;
      const auto accept = read_accept(datagram, asked_bytes);
      if (!accept) continue;
      if (!accept->knows_datagram_bytes) {
        refuse(refusal_number(Refusal::datagram_bytes, kDatagramBytes), header.version);
        return nullptr;
      }
      return std::make_unique<Session>(accept->session, monotonic_ns(), nullptr, datagram_bytes_,
                                       kMaxReplyBytes);
    }
  }
  return nullptr;
}

// DTLS repeats its own flights; afterwards the sealed hello is repeated until it is answered.
std::unique_ptr<Session> SessionOpener::open_sealed() {
  std::unique_ptr<Dtls> dtls = key_->connect();
  if (!dtls || dtls->handshake({}) == Dtls::Progress::failed) {
    counters_.reject(Cause::no_memory);
    return nullptr;
  }
  int64_t hello_at = 0, wait_ns = kFirstHelloAfterNs;
  const int64_t until = monotonic_ns() + kAddressTimeoutNs;
  for (int64_t now = monotonic_ns(); !thread_.stopping() && now < until; now = monotonic_ns()) {
    if (dtls->repeat_flight() == Dtls::Progress::failed) return nullptr;
    auto datagrams = dtls->take_outgoing();
    if (dtls->established() && now >= hello_at) {
      const Parameters parameters{.datagram_bytes = static_cast<uint16_t>(datagram_bytes_)};
      datagrams.push_back(seal_number(*dtls, Type::hello, parameters_number(parameters)));
      hello_at = now + wait_ns;
      wait_ns = std::min(wait_ns * 2, kLongestHelloAfterNs);
    }
    for (const auto& datagram : datagrams)
      if (::send(fd_, datagram.data(), datagram.size(), MSG_NOSIGNAL) < 0 && errno == ECONNREFUSED)
        return nullptr;
    const int64_t next = dtls->established() ? hello_at : now + dtls->timeout_ns();
    std::span<std::byte> datagram;
    if (!wait_for_answer(std::min(next, until), datagram)) return nullptr;
    if (auto session = receive_answer(dtls, datagram)) return session;
    if (is_refused_) return nullptr;
  }
  return nullptr;
}

std::unique_ptr<Session> SessionOpener::receive_answer(std::unique_ptr<Dtls>& dtls,
                                                       std::span<std::byte> datagram) {
  // A plaintext refusal counts only before the handshake completes, and only if it repeats our nonce.
  Header header;
  if (read_header(datagram, header)) {
    if (header.type != Type::refuse || dtls->established() || header.session != dtls->nonce()) return nullptr;
    refuse(read_number(datagram.subspan(kHeaderBytes)).value_or(0), header.version);
    return nullptr;
  }
  const RecordDatagram about = inspect_records(datagram);
  if (about.kind == RecordDatagram::Kind::handshake && !dtls->established()) {
    if (dtls->handshake(datagram) != Dtls::Progress::failed) return nullptr;
    counters_.reject(Cause::malformed);
    is_refused_ = true;
    return nullptr;
  }
  if (about.kind != RecordDatagram::Kind::data) return nullptr;
  const auto answer = open_number(*dtls, about, datagram);
  if (!answer) {
    counters_.reject(Cause::bad_key);
  } else if (answer->type == Type::refuse) {
    refuse(answer->number, kTransportVersion);
  } else if (answer->type == Type::accept) {
    if (read_parameters(answer->number) ==
        Parameters{.datagram_bytes = static_cast<uint16_t>(datagram_bytes_)})
      return std::make_unique<Session>(dtls->nonce(), monotonic_ns(), std::move(dtls), datagram_bytes_,
                                       kMaxReplyBytes);
    refuse(refusal_number(Refusal::datagram_bytes, read_parameters(answer->number).datagram_bytes),
           kTransportVersion);
  }
  return nullptr;
}

void SessionOpener::refuse(uint64_t answer, uint8_t version) {
  is_refused_ = true;
  const auto set = [&](Cause cause, const std::string& reason) {
    counters_.reject(cause);
    refusal_ = uri_text(uri_) + ": the renderer " + reason;
  };
  switch (static_cast<Refusal>(answer & 0xffff)) {
    case Refusal::version_mismatch:
      return set(Cause::version, "speaks transport version " + std::to_string(version) + ", this program " +
                                     std::to_string(kTransportVersion) +
                                     "; use the same version on both sides");
    case Refusal::bad_key:
      return set(Cause::bad_key, key_ ? "has another key or none; give both sides the same key file"
                                      : "requires a key; give both sides the same key file");
    case Refusal::full:
      return set(Cause::full, "has as many publishers as it allows");
    case Refusal::datagram_bytes:
      return set(Cause::oversize, "takes datagrams of at most " + std::to_string(answer >> 16 & 0xffff) +
                                      " bytes; choose ?mtu= accordingly on both sides");
  }
  set(Cause::version, "refuses, and gives a reason that this version does not know");
}

}  // namespace fire3dv::transport::udp
