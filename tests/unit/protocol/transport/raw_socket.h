// Plain socket for arbitrary bytes.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <random>
#include <span>
#include <string>
#include <vector>

#include "base/unique_fd.h"
#include "protocol/transport/core/address.h"

namespace fire3dv::transport::test {

class RawSocket {
 public:
  RawSocket(const std::string& uri_of_ipv4_listener, int type) {
    const auto uri = parse_uri(uri_of_ipv4_listener);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(uri->port);
    ::inet_pton(AF_INET, uri->host.c_str(), &address.sin_addr);
    fd_ = UniqueFd(::socket(AF_INET, type | SOCK_CLOEXEC, 0));
    connected_ = ::connect(fd_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  bool connected() const { return connected_; }
  bool send(std::span<const std::byte> bytes) {
    return ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  // Receives bytes within the hang limit; empty at the end of the stream.
  std::vector<std::byte> receive(int timeout_ms = 60'000) {
    std::vector<std::byte> bytes(65536);
    pollfd polled{fd_.get(), POLLIN, 0};
    if (::poll(&polled, 1, timeout_ms) <= 0) return {};
    const ssize_t got = ::recv(fd_.get(), bytes.data(), bytes.size(), 0);
    bytes.resize(got > 0 ? static_cast<size_t>(got) : 0);
    return bytes;
  }
  // Reads to the end; returns true if the peer closed.
  bool closed_by_peer() {
    while (!receive().empty()) {
    }
    std::byte one;
    return ::recv(fd_.get(), &one, 1, MSG_DONTWAIT) == 0 || (errno != EAGAIN && errno != EWOULDBLOCK);
  }
  int fd() const { return fd_.get(); }

 private:
  UniqueFd fd_;
  bool connected_ = false;
};

inline std::vector<std::byte> random_bytes(size_t count, uint32_t seed) {
  std::mt19937 generator(seed);
  std::vector<std::byte> bytes(count);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(generator());
  return bytes;
}

}  // namespace fire3dv::transport::test
