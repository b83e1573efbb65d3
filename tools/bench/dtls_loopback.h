// A DTLS 1.2 connection over loopback, both ends in this thread.
#pragma once

#include <netinet/in.h>
#include <openssl/ssl.h>

#include <memory>
#include <span>
#include <string>

#include "protocol/error.h"
#include "protocol/transport/unique_fd.h"

namespace fire3dv::bench {

// A UDP socket on a free port of 127.0.0.1, which does not block.
struct LoopbackSocket {
  transport::UniqueFd fd;
  sockaddr_in address{};
};
Result<LoopbackSocket> bind_loopback();

// Two of them that are connected with each other.
struct SocketPair {
  transport::UniqueFd from, to;
};
Result<SocketPair> make_socket_pair();

// Datagrams of a handshake in both directions, UDP payload alone.
struct HandshakeCount {
  size_t datagrams = 0, bytes = 0;
  size_t round_trips = 0;  // before the client may send application data
  bool last_was_client = false;
  void add(bool is_client, size_t datagram_bytes);
};

class DtlsLoopback {
 public:
  // Does the handshake, with a cookie exchange. `cipher` is OpenSSL's name of a PSK suite.
  static Result<std::unique_ptr<DtlsLoopback>> open(const char* cipher);

  // One record in one datagram.
  bool send(std::span<const std::byte> payload);
  // Opens the next datagram. False unless it holds exactly `expected`.
  bool receive(std::span<const std::byte> expected);
  int receiving_fd() const { return sockets_.to.get(); }
  const HandshakeCount& handshake() const { return count_; }

 private:
  using Context = std::unique_ptr<SSL_CTX, decltype(&::SSL_CTX_free)>;
  using Connection = std::unique_ptr<SSL, decltype(&::SSL_free)>;
  DtlsLoopback() = default;
  Result<void> connect(const char* cipher);
  Connection make_end(const Context& context, int fd, int peer_fd, bool is_client);

  struct Side {
    HandshakeCount* count = nullptr;
    bool is_client = false;
  };
  static long on_write(BIO* bio, int operation, const char* data, size_t bytes, int, long, int result,
                       size_t* processed);

  SocketPair sockets_;
  HandshakeCount count_;
  Side sides_[2];
  Context client_context_{nullptr, ::SSL_CTX_free}, server_context_{nullptr, ::SSL_CTX_free};
  Connection client_{nullptr, ::SSL_free}, server_{nullptr, ::SSL_free};
};

}  // namespace fire3dv::bench
