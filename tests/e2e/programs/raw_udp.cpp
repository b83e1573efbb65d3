// Raw UDP session without a key: hello, one bundle of scene edits, acknowledgements.
#include "tests/e2e/programs/raw_udp.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <optional>

#include "base/clock.h"
#include "base/random.h"
#include "base/unique_fd.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/udp/udp_handshake.h"
#include "protocol/transport/udp/udp_session.h"
#include "tests/e2e/programs/raw_peer.h"

namespace fire3dv::test {
namespace {

using namespace transport;
using namespace transport::udp;

constexpr int64_t kAnswerLimitNs = 3'000'000'000;

UniqueFd connected_socket(const std::string& uri) {
  const auto parsed = parse_uri(uri);
  UniqueFd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!parsed || !fd) throw PeerClosed("cannot use " + uri);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(parsed->port);
  ::inet_pton(AF_INET, parsed->host.c_str(), &address.sin_addr);
  if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw PeerClosed("cannot connect to " + uri);
  return fd;
}

using Buffer = std::array<std::byte, kMaxDatagramBytes + 1>;

// Returns the next datagram, or nothing after 5 ms.
std::optional<std::span<std::byte>> receive(int fd, Buffer& buffer) {
  pollfd ready{fd, POLLIN, 0};
  if (::poll(&ready, 1, 5) <= 0) return std::nullopt;
  const ssize_t got = ::recv(fd, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (got < 0) throw PeerClosed("the renderer does not listen");
  return std::span(buffer.data(), static_cast<size_t>(got));
}

void send(int fd, std::span<const std::byte> datagram) {
  if (::send(fd, datagram.data(), datagram.size(), MSG_NOSIGNAL) > 0) RawPeer::count_bytes(datagram.size());
}

uint64_t open_session(int fd) {
  const uint64_t nonce = random_id();
  uint64_t cookie = 0;
  Buffer buffer;
  int64_t hello_at_ns = 0;
  for (const int64_t until = monotonic_ns() + kAnswerLimitNs; monotonic_ns() < until && !stop_requested();) {
    if (monotonic_ns() >= hello_at_ns) {
      send(fd, write_hello(nonce, cookie));
      hello_at_ns = monotonic_ns() + 50'000'000;
    }
    const auto datagram = receive(fd, buffer);
    Header header;
    if (!datagram || !read_header(*datagram, header) || header.session != nonce) continue;
    const auto number = read_number(datagram->subspan(kHeaderBytes));
    if (header.type == Type::refuse) throw PeerClosed("the renderer refuses the session");
    if (header.type == Type::cookie && cookie == 0 && number) {
      cookie = *number;
      hello_at_ns = 0;
    }
    if (header.type != Type::accept) continue;
    if (const auto accept = read_accept(*datagram)) return accept->session;
  }
  throw PeerClosed("no session");
}

}  // namespace

void send_bundle(const std::string& uri, const std::vector<std::byte>& bundle) {
  const UniqueFd fd = connected_socket(uri);
  Session session(open_session(fd.get()), monotonic_ns(), nullptr);
  session.state_sender().push(ControlSender::prepare(bundle), kMaxControlBytes);
  Buffer buffer;
  while (!session.state_sender().idle()) {
    if (stop_requested() || monotonic_ns() - session.last_received_ns() > kAnswerLimitNs)
      throw PeerClosed("stopped");
    session.emit_due(monotonic_ns(), [&](std::span<const std::byte> datagram) { send(fd.get(), datagram); });
    while (const auto datagram = receive(fd.get(), buffer)) {
      Header header;
      if (!read_header(*datagram, header) || header.session != session.id()) continue;
      if (header.type == Type::reset || header.type == Type::bye)
        throw PeerClosed("the renderer ended the session");
      std::span<const std::byte> payload;
      if (session.receive(header, *datagram, monotonic_ns(), payload) != Session::Received::payload) continue;
      session.control(header.type, payload, kMaxControlBytes, monotonic_ns());
      if (session.state_sender().idle()) return;
      session.emit_due(monotonic_ns(), [&](std::span<const std::byte> out) { send(fd.get(), out); });
    }
  }
}

}  // namespace fire3dv::test
