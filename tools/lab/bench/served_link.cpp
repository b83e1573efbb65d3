#include "tools/lab/bench/served_link.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "base/clock.h"
#include "protocol/transport/udp/udp_handshake.h"

namespace fire3dv::bench {
namespace {

namespace udp = transport::udp;
using fire3dv::monotonic_ns;
using Kind = udp::RecordDatagram::Kind;

constexpr uint64_t kSession = 17, kCookie = 1;
constexpr int kMaxHandshakeSteps = 10'000;

// The bench's key in a file, as links take it.
struct KeyFile {
  char path[32] = "/tmp/fire3dv-bench-XXXXXX";
  UniqueFd fd{::mkstemp(path)};  // mode 0600
  bool written = ::dprintf(fd.get(), "%s\n", std::string(64, '1').c_str()) > 0;
  ~KeyFile() { ::unlink(path); }
};

// One for all sessions, as a link has one.
const Result<std::shared_ptr<const udp::PreSharedKey>>& bench_key() {
  static const auto key =
      udp::PreSharedKey::from_secret(transport::Secret(std::vector<std::byte>(32, std::byte{0x11})));
  return key;
}

const udp::Dtls::Cookies& cookies() {
  static const udp::Dtls::Cookies one{[] { return kCookie; },
                                      [](uint64_t cookie) { return cookie == kCookie; }};
  return one;
}

// A UDP socket on a free port of 127.0.0.1, which does not block.
struct LoopbackSocket {
  UniqueFd fd;
  sockaddr_in address{};
};
Result<LoopbackSocket> bind_loopback() {
  LoopbackSocket socket{UniqueFd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0))};
  socket.address.sin_family = AF_INET;
  socket.address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const address = reinterpret_cast<sockaddr*>(&socket.address);
  socklen_t length = sizeof socket.address;
  if (::bind(socket.fd.get(), address, length) != 0 || ::getsockname(socket.fd.get(), address, &length) != 0)
    return Error{std::string("a UDP socket on loopback: ") + std::strerror(errno)};
  return socket;
}

}  // namespace

Result<SocketPair> make_socket_pair() {
  auto from = bind_loopback(), to = bind_loopback();
  if (!from) return from.error();
  if (!to) return to.error();
  const auto connect = [](const LoopbackSocket& socket, const LoopbackSocket& peer) {
    return ::connect(socket.fd.get(), reinterpret_cast<const sockaddr*>(&peer.address),
                     sizeof peer.address) == 0;
  };
  if (!connect(*from, *to) || !connect(*to, *from))
    return Error{std::string("UDP sockets on loopback: ") + std::strerror(errno)};
  return SocketPair{std::move(from->fd), std::move(to->fd)};
}

Result<SessionPair> make_session_pair(bool sealed, size_t datagram_bytes) {
  std::unique_ptr<udp::Dtls> from, to;
  if (sealed) {
    const auto& key = bench_key();
    if (!key) return key.error();
    from = (*key)->connect();
    to = (*key)->listen();
    bool greeted = false;
    from->handshake({});
    for (int step = 0; step < kMaxHandshakeSteps && !(from->established() && to->established()); ++step) {
      for (const auto& datagram : from->take_outgoing()) {
        if (greeted) {
          to->handshake(datagram);
        } else if (to->check_client_hello(datagram, cookies())) {
          greeted = true;
          to->handshake({});
        }
      }
      for (const auto& datagram : to->take_outgoing()) from->handshake(datagram);
      from->repeat_flight();
      if (greeted) to->repeat_flight();
    }
    if (!from->established() || !to->established()) return Error{"a DTLS handshake does not end"};
  }
  SessionPair pair;
  pair.from = std::make_unique<udp::Session>(kSession, monotonic_ns(), std::move(from), datagram_bytes);
  pair.to = std::make_unique<udp::Session>(kSession, monotonic_ns(), std::move(to), datagram_bytes);
  return pair;
}

Result<std::unique_ptr<udp::Dtls>> make_pending_handshake() {
  const auto& key = bench_key();
  if (!key) return key.error();
  const auto from = (*key)->connect();
  auto to = (*key)->listen();
  from->handshake({});
  for (int step = 0; step < kMaxHandshakeSteps; ++step) {
    for (const auto& datagram : from->take_outgoing()) {
      if (!to->check_client_hello(datagram, cookies())) continue;
      to->handshake({});
      to->take_outgoing();
      return to;
    }
    for (const auto& datagram : to->take_outgoing()) from->handshake(datagram);
    from->repeat_flight();
  }
  return Error{"a DTLS handshake does not begin"};
}

void HandshakeCount::add(bool is_publisher, size_t datagram_bytes) {
  ++datagrams;
  bytes += datagram_bytes;
  if (is_publisher && !last_was_publisher) ++round_trips;
  last_was_publisher = is_publisher;
}

Result<void> ServedLink::open(size_t poses, size_t datagram_bytes, bool sealed) {
  auto listener = bind_loopback();
  if (!listener) return listener.error();
  listener_ = std::move(listener->fd);
  datagram_bytes_ = datagram_bytes;
  const KeyFile key_file;
  transport::PublisherOptions options;
  if (sealed) {
    if (!key_file.written) return Error{std::string(key_file.path) + ": the key cannot be written"};
    options.key_file = key_file.path;
    const auto& key = bench_key();
    if (!key) return key.error();
    key_ = *key;
  }
  auto simulator = Simulator::open("udp://127.0.0.1:" + std::to_string(ntohs(listener->address.sin_port)) +
                                       "?mtu=" + std::to_string(datagram_bytes),
                                   poses, options);
  if (!simulator) return simulator.error();
  simulator_ = std::move(*simulator);
  const int64_t give_up_ns = monotonic_ns() + 60 * fire3dv::kSecondNs;
  while (!pose_came_ && monotonic_ns() < give_up_ns) {
    simulator_->publish();
    pollfd polled{listener_.get(), POLLIN, 0};
    ::poll(&polled, 1, 1);
    serve();
  }
  if (!pose_came_) return Error{"the publisher does not reach the listener of this program"};
  return {};
}

void ServedLink::serve() {
  std::byte buffer[udp::kMaxDatagramBytes];
  while (true) {
    socklen_t length = sizeof publisher_;
    const ssize_t got = ::recvfrom(listener_.get(), buffer, sizeof buffer, 0,
                                   reinterpret_cast<sockaddr*>(&publisher_), &length);
    if (got <= 0) return;
    const std::span<std::byte> datagram(buffer, static_cast<size_t>(got));
    key_ ? handle_sealed(datagram) : handle(datagram);
  }
}

void ServedLink::handle(std::span<std::byte> datagram) {
  udp::Header header;
  if (!udp::read_header(datagram, header)) return;
  if (header.type == udp::Type::hello) {
    const uint64_t cookie = udp::read_hello(datagram).cookie;
    std::vector<std::byte> answer;
    if (cookie != kCookie) {
      const auto asked = udp::write_answer(udp::Type::cookie, header.session, kCookie);
      answer.assign(asked.begin(), asked.end());
    } else {
      answer = udp::write_accept(header.session, kSession, static_cast<uint16_t>(datagram_bytes_));
      if (!session_)
        session_ = std::make_unique<udp::Session>(kSession, monotonic_ns(), nullptr, datagram_bytes_);
    }
    if (counted_.empty() || counted_.back().second != cookie) count(datagram.size(), {answer});
    counted_.emplace_back(datagram.size(), cookie);
    return reply(answer);
  }
  std::span<const std::byte> payload;
  if (session_ &&
      session_->receive(header, datagram, monotonic_ns(), payload) == udp::Session::Received::payload)
    take(header.type, payload, datagram.size());
}

void ServedLink::handle_sealed(std::span<std::byte> datagram) {
  const udp::RecordDatagram about = udp::inspect_records(datagram);
  if (about.kind != Kind::data) return shake_hands(about, datagram);
  if (session_) {
    udp::Type type{};
    std::span<const std::byte> payload;
    if (session_->open(about, datagram, monotonic_ns(), type, payload) == udp::Session::Received::payload)
      take(type, payload, datagram.size());
  } else if (dtls_ && dtls_->established()) {
    const size_t bytes = datagram.size();
    const auto hello = udp::open_number(*dtls_, about, datagram);
    if (!hello || hello->type != udp::Type::hello) return;
    const auto answer = udp::seal_number(*dtls_, udp::Type::accept, hello->number);
    count(bytes, {answer});
    reply(answer);
    session_ = std::make_unique<udp::Session>(kSession, monotonic_ns(), std::move(dtls_), datagram_bytes_);
  }
}

void ServedLink::shake_hands(const udp::RecordDatagram& about, std::span<const std::byte> datagram) {
  if (session_ || about.kind == Kind::none) return;
  if (!dtls_) dtls_ = key_->listen();
  if (about.kind == Kind::client_hello) {
    if (!greeted_ && dtls_->check_client_hello(datagram, cookies())) {
      greeted_ = true;
      dtls_->handshake({});
    }
  } else if (greeted_) {
    dtls_->handshake(datagram);
  }
  // A repetition, when this thread had to wait for a core, is answered and not counted again.
  const auto answers = dtls_->take_outgoing();
  const std::pair<size_t, uint64_t> greeting(datagram.size(), about.nonce);
  if (!answers.empty() && std::find(counted_.begin(), counted_.end(), greeting) == counted_.end()) {
    counted_.push_back(greeting);
    count(datagram.size(), answers);
  }
  for (const auto& answer : answers) reply(answer);
}

void ServedLink::count(size_t question_bytes, const std::vector<std::vector<std::byte>>& answers) {
  count_.add(true, question_bytes);
  for (const auto& answer : answers) count_.add(false, answer.size());
}

void ServedLink::take(udp::Type type, std::span<const std::byte> payload, size_t datagram_bytes) {
  if (type == udp::Type::pose) {
    pose_came_ = true;
    added_bytes_ = datagram_bytes - payload.size();
  }
  const int64_t now_ns = monotonic_ns();
  if (session_->control(type, payload, SIZE_MAX, now_ns) == udp::ControlReceiver::Outcome::complete)
    session_->receiver().take();
  session_->emit_due(now_ns, [this](auto answer) { reply(answer); });
}

void ServedLink::reply(std::span<const std::byte> bytes) const {
  ::sendto(listener_.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&publisher_),
           sizeof publisher_);
}

}  // namespace fire3dv::bench
