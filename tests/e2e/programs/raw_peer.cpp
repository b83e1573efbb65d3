// Raw TCP peer: connection, framing and replies.
#include "tests/e2e/programs/raw_peer.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <utility>

#include "protocol/transport/core/address.h"

namespace fire3dv::test {
namespace {

using namespace std::chrono_literals;
using transport::tcp::FrameKind;

uint64_t total_bytes_sent = 0;
bool announced = false;

}  // namespace

bool stop_requested() {
  static bool stop = false;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char byte;
  if (!stop && ::poll(&input, 1, 0) > 0) stop = ::read(STDIN_FILENO, &byte, 1) <= 0 || byte == '\n';
  return stop;
}

void announce_sent() {
  static bool announced_sent = false;
  if (std::exchange(announced_sent, true)) return;
  std::puts("sent");
  std::fflush(stdout);
}

uint64_t RawPeer::bytes_sent() {
  return total_bytes_sent;
}

void RawPeer::count_bytes(uint64_t bytes) {
  total_bytes_sent += bytes;
}

RawPeer::RawPeer(const std::string& uri, int receive_buffer_bytes)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const auto parsed = transport::parse_uri(uri);
  if (!parsed || !socket_) throw PeerClosed("cannot use " + uri);
  if (receive_buffer_bytes > 0)
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof receive_buffer_bytes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(parsed->port);
  ::inet_pton(AF_INET, parsed->host.c_str(), &address.sin_addr);
  if (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw PeerClosed("cannot connect to " + uri);
  send(transport::tcp::write_preface({}));
  if (std::exchange(announced, true)) return;
  std::puts("begun");
  std::fflush(stdout);
}

void RawPeer::send(FrameKind kind, const wire::Bytes& message) {
  send(transport::tcp::write_frame_header(kind, static_cast<uint32_t>(message.size())));
  send(std::span(message));
}

// Sending polls the stop request: a renderer that stops reading must not keep the program from ending.
void RawPeer::send(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<size_t>(sent));
      total_bytes_sent += static_cast<uint64_t>(sent);
      continue;
    }
    if (errno != EAGAIN && errno != EINTR) throw PeerClosed("the renderer closed the connection");
    if (stop_requested()) throw PeerClosed("stopped");
    pollfd ready{socket_.get(), POLLOUT, 0};
    ::poll(&ready, 1, 20);
  }
}

void RawPeer::read_replies() {
  std::array<std::byte, 65536> buffer;
  for (;;) {
    const ssize_t got = ::recv(socket_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR))
      throw PeerClosed("the renderer closed the connection");
    if (got < 0) return;
    std::span<const std::byte> bytes(buffer.data(), static_cast<size_t>(got));
    const size_t skip = std::min(preface_bytes_left_, bytes.size());
    preface_bytes_left_ -= skip;
    parser_->feed(bytes.subspan(skip), [this](FrameKind, std::vector<std::byte>&& message) {
      const auto decoded = decoder_.decode(message);
      const auto* pong = decoded ? std::get_if<wire::Pong>(&*decoded) : nullptr;
      if (pong != nullptr) pongs_ = pong->id;
    });
  }
}

void RawPeer::sync(std::chrono::milliseconds timeout) {
  control(wire::encode(wire::Ping{++pings_, 1}));
  const auto until = std::chrono::steady_clock::now() + timeout;
  while (pongs_ < pings_ && std::chrono::steady_clock::now() < until) {
    if (stop_requested()) throw PeerClosed("stopped");
    pollfd ready{socket_.get(), POLLIN, 0};
    ::poll(&ready, 1, 5);
    read_replies();
  }
}

}  // namespace fire3dv::test
