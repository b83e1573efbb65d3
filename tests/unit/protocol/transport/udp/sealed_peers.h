// Both ends of sealed udp:// sessions that send only the datagrams of a test.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "protocol/transport/udp/udp_handshake.h"
#include "protocol/transport/udp/udp_session.h"
#include "tests/unit/protocol/transport/raw_socket.h"
#include "tests/unit/protocol/transport/secure_fixture.h"

namespace fire3dv::transport::test {

using RecordKind = udp::RecordDatagram::Kind;

inline RecordKind kind_of(std::span<const std::byte> datagram) {
  return udp::inspect_records(datagram).kind;
}

// Nothing when these are not the bytes of a datagram in the open.
inline std::optional<udp::Header> header_of(std::span<const std::byte> datagram) {
  udp::Header header;
  return udp::read_header(datagram, header) ? std::optional(header) : std::nullopt;
}

// The key that Secured writes to a file of this digit.
inline std::shared_ptr<const udp::PreSharedKey> key_of(char digit) {
  return *udp::PreSharedKey::from_secret(
      Secret(std::vector<std::byte>(32, static_cast<std::byte>((digit - '0') * 0x11))));
}
// Of somebody who has read the name of the key on the network, and has not the key.
inline std::shared_ptr<const udp::PreSharedKey> guess_of(char digit) {
  return *udp::PreSharedKey::create({1, 2, 3}, key_of(digit)->identity());
}

struct RawPublisher {
  explicit RawPublisher(const std::string& uri) : socket(uri, SOCK_DGRAM) {}
  RawSocket socket;
  std::shared_ptr<const udp::PreSharedKey> key = key_of('1');
  std::unique_ptr<udp::Dtls> dtls;
  std::vector<std::vector<std::byte>> sent;  // the handshake's datagrams
  std::unique_ptr<udp::Session> session;

  void send_flight() {
    for (auto& datagram : dtls->take_outgoing()) {
      EXPECT_TRUE(socket.send(datagram));
      sent.push_back(std::move(datagram));
    }
  }
  // Until the handshake is over, or nothing has come for so long.
  bool shake_hands(int timeout_ms = 60'000) {
    dtls = key->connect();
    sent.clear();
    dtls->handshake({});
    send_flight();
    while (!dtls->established()) {
      const auto answer = socket.receive(timeout_ms);
      if (answer.empty() || header_of(answer)) return false;
      if (kind_of(answer) != RecordKind::handshake) continue;
      if (dtls->handshake(answer) == udp::Dtls::Progress::failed) return false;
      send_flight();
    }
    return true;
  }
  // The sealed hello's answer.
  udp::SealedNumber say_hello(const udp::Parameters& parameters = {}) {
    EXPECT_TRUE(socket.send(udp::seal_number(*dtls, udp::Type::hello, udp::parameters_number(parameters))));
    while (true) {
      auto answer = socket.receive();
      if (answer.empty()) return {};
      if (kind_of(answer) != RecordKind::data) continue;
      const auto number = udp::open_number(*dtls, udp::inspect_records(answer), answer);
      if (number) return *number;
    }
  }
  void greet() {
    ASSERT_TRUE(shake_hands());
    ASSERT_EQ(say_hello().type, udp::Type::accept);
    session = std::make_unique<udp::Session>(1, 0, std::move(dtls));
  }
  void ping() {
    session->emit_bare(udp::Type::ping, [&](auto datagram) { EXPECT_TRUE(socket.send(datagram)); });
  }
  // The type of the next sealed message; nothing when it does not come or open.
  udp::Type hear(int timeout_ms = 60'000) {
    while (true) {
      auto answer = socket.receive(timeout_ms);
      const auto about = udp::inspect_records(answer);
      if (about.kind == RecordKind::handshake) continue;
      udp::Type type{};
      std::span<const std::byte> payload;
      if (about.kind == RecordKind::data) session->open(about, answer, 0, type, payload);
      return type;
    }
  }
};

struct RawListener {
  explicit RawListener(uint16_t at_port = 0) : fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(at_port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    EXPECT_EQ(::bind(fd.get(), reinterpret_cast<sockaddr*>(&address), length), 0);
    ::getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &length);
    port = ntohs(address.sin_port);
  }
  UniqueFd fd;
  uint16_t port = 0;
  sockaddr_in from{};
  std::vector<std::byte> datagram;
  std::unique_ptr<udp::Session> session;

  std::string uri() const { return "udp://127.0.0.1:" + std::to_string(port); }
  RecordKind receive() {
    datagram.resize(udp::kMaxDatagramBytes);
    pollfd polled{fd.get(), POLLIN, 0};
    EXPECT_EQ(::poll(&polled, 1, 60'000), 1);
    socklen_t length = sizeof from;
    const ssize_t got = ::recvfrom(fd.get(), datagram.data(), datagram.size(), 0,
                                   reinterpret_cast<sockaddr*>(&from), &length);
    datagram.resize(got > 0 ? static_cast<size_t>(got) : 0);
    return kind_of(datagram);
  }
  // The type of the session's next message; `hello` when the publisher restarts the handshake.
  udp::Type hear() {
    while (true) {
      const RecordKind kind = receive();
      if (kind == RecordKind::client_hello) return udp::Type::hello;
      udp::Type type{};
      std::span<const std::byte> payload;
      if (kind == RecordKind::data && session->open(udp::inspect_records(datagram), datagram, 0, type,
                                                    payload) == udp::Session::Received::payload)
        return type;
    }
  }
  void send(std::span<const std::byte> bytes) const {
    ::sendto(fd.get(), bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&from), sizeof from);
  }
  void emit(udp::Type type) {
    session->emit_bare(type, [&](auto bytes) { send(bytes); });
  }
  // Accepts the next publisher with the key '1'.
  void accept() {
    const auto key = key_of('1');
    const udp::Dtls::Cookies cookies{[] { return uint64_t{5}; }, [](uint64_t cookie) { return cookie == 5; }};
    std::unique_ptr<udp::Dtls> dtls = key->listen();
    bool greeted = false;
    while (true) {
      const RecordKind kind = receive();
      if (kind == RecordKind::client_hello &&
          (!greeted || udp::inspect_records(datagram).nonce != dtls->nonce())) {
        if (greeted) dtls = key->listen();
        greeted = dtls->check_client_hello(datagram, cookies);
        if (greeted) dtls->handshake({});
      } else if (kind == RecordKind::handshake && greeted && !dtls->established()) {
        dtls->handshake(datagram);
      } else if (kind == RecordKind::data && dtls->established()) {
        const auto hello = udp::open_number(*dtls, udp::inspect_records(datagram), datagram);
        if (!hello || hello->type != udp::Type::hello) continue;
        send(udp::seal_number(*dtls, udp::Type::accept, hello->number));
        session = std::make_unique<udp::Session>(1, 0, std::move(dtls));
        return;
      }
      for (const auto& answer : dtls->take_outgoing()) send(answer);
    }
  }
};

}  // namespace fire3dv::transport::test
