#include "tools/bench/sealed_link.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "protocol/transport/clock.h"
#include "protocol/transport/udp_handshake.h"

namespace fire3dv::bench {
namespace {

namespace udp = transport::udp;
using transport::monotonic_ns;

// The bench's key in a file, as links take it.
struct KeyFile {
  char path[32] = "/tmp/fire3dv-bench-XXXXXX";
  transport::UniqueFd fd{::mkstemp(path)};  // mode 0600
  bool written = ::dprintf(fd.get(), "%s\n", std::string(64, '1').c_str()) > 0;
  ~KeyFile() { ::unlink(path); }
};

udp::PreSharedKey bench_key() {
  return udp::PreSharedKey(transport::Secret(std::vector<std::byte>(32, std::byte{0x11})));
}

}  // namespace

std::unique_ptr<udp::Session> make_sealed_session(udp::PreSharedKey::Side side, const udp::Random& publishers,
                                                  const udp::Random& listeners, size_t datagram_bytes) {
  return std::make_unique<udp::Session>(kBenchSession, monotonic_ns(),
                                        bench_key().make_seal(side, kBenchSession, publishers, listeners),
                                        datagram_bytes);
}

Result<void> SealedLink::open(size_t poses, size_t datagram_bytes) {
  auto listener = bind_loopback();
  if (!listener) return listener.error();
  listener_ = std::move(listener->fd);
  const KeyFile key_file;
  if (!key_file.written) return Error{std::string(key_file.path) + ": the key cannot be written"};
  transport::PublisherOptions options;
  options.key_file = key_file.path;
  auto simulator = Simulator::open("udp://127.0.0.1:" + std::to_string(ntohs(listener->address.sin_port)) +
                                       "?mtu=" + std::to_string(datagram_bytes),
                                   poses, options);
  if (!simulator) return simulator.error();
  simulator_ = std::move(*simulator);
  const int64_t give_up_ns = monotonic_ns() + 60 * transport::kSecondNs;
  while (!pose_came_ && monotonic_ns() < give_up_ns) {
    simulator_->publish();
    pollfd polled{listener_.get(), POLLIN, 0};
    ::poll(&polled, 1, 1);
    serve();
  }
  if (!pose_came_) return Error{"the publisher does not reach the listener of this program"};
  return {};
}

void SealedLink::serve() {
  std::byte buffer[udp::kMaxDatagramBytes];
  while (true) {
    socklen_t length = sizeof publisher_;
    const ssize_t got = ::recvfrom(listener_.get(), buffer, sizeof buffer, 0,
                                   reinterpret_cast<sockaddr*>(&publisher_), &length);
    if (got <= 0) return;
    handle({buffer, static_cast<size_t>(got)});
  }
}

void SealedLink::handle(std::span<std::byte> datagram) {
  udp::Header header;
  if (!udp::read_header(datagram, header)) return;
  if (header.type == udp::Type::hello) return answer_hello(header.session, datagram);
  std::span<const std::byte> payload;
  const int64_t now_ns = monotonic_ns();
  if (!session_ || session_->hear(header, datagram, now_ns, payload) != udp::Session::Heard::payload) return;
  if (header.type == udp::Type::pose) {
    pose_came_ = true;
    added_bytes_ = datagram.size() - payload.size();
  }
  if (session_->control(header, payload, SIZE_MAX, now_ns) == udp::ControlReceiver::Outcome::complete)
    session_->receiver().take();
  session_->emit_due(now_ns, [this](auto answer) { reply(answer); });
}

// A publisher repeats its hello when this thread had to wait for a core. It gets the same answer, which is
// not counted again.
void SealedLink::answer_hello(uint64_t nonce, std::span<const std::byte> hello) {
  const udp::HelloFields fields = udp::read_hello(hello);
  std::vector<std::byte>& answer = fields.cookie != 0 ? accept_ : cookie_;
  const bool is_new = nonce_ != nonce || answer.empty();
  if (nonce_ != nonce) accept_.clear();
  nonce_ = nonce;
  if (is_new && fields.cookie != 0) {
    const udp::Random random = udp::make_random();
    const udp::PreSharedKey key = bench_key();
    answer = udp::write_accept(nonce, kBenchSession, fields.random, random, &key, fields.datagram_bytes);
    session_ =
        make_sealed_session(udp::PreSharedKey::Side::listener, fields.random, random, fields.datagram_bytes);
  } else if (is_new) {
    const udp::Answer cookie = udp::write_answer(udp::Type::cookie, nonce, 1);
    answer.assign(cookie.begin(), cookie.end());
    count_ = {};
  }
  if (is_new) {
    count_.add(true, hello.size());
    count_.add(false, answer.size());
  }
  reply(answer);
}

void SealedLink::reply(std::span<const std::byte> bytes) const {
  ::sendto(listener_.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&publisher_),
           sizeof publisher_);
}

}  // namespace fire3dv::bench
