// Parts of a TCP connection that both sides share: socket options, and TLS.
#pragma once

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/open.h"
#include "protocol/transport/tcp/tcp_outbox.h"

struct ssl_ctx_st;
struct ssl_st;

namespace fire3dv::transport::tcp {

// Limit of unsent bytes in the kernel. Newer poses cannot replace these bytes, which would amount to seconds
// on a slow link.
constexpr int kMaxUnsentInKernelBytes = 16 << 10;

// Sets the options. The kernel detects a vanished peer (cable, power) within about 10 seconds.
inline void tune_socket(int fd) {
  const auto set = [fd](int level, int option, int value) {
    ::setsockopt(fd, level, option, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(IPPROTO_TCP, TCP_NOTSENT_LOWAT, kMaxUnsentInKernelBytes);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 4);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 10'000);
}

// True for a TCP self-connection: a client that retries an unused local port may get that port as its own. It
// would prevent the real listener from binding it.
inline bool connected_to_itself(int fd) {
  Address own, other;
  own.length = other.length = sizeof own.storage;
  return ::getsockname(fd, own.get(), &own.length) == 0 &&
         ::getpeername(fd, other.get(), &other.length) == 0 && own == other;
}

// Certificates and keys, read once when the link is opened. Null for tcp://.
using TlsContext = std::shared_ptr<ssl_ctx_st>;
Result<TlsContext> make_server_context(const std::string& uri, const TlsListenerOptions& options);
Result<TlsContext> make_client_context(const std::string& uri, const TlsPublisherOptions& options);

// TLS 1.3 session of one connection, without socket I/O: the caller passes received bytes and sends the
// produced ones, so that tcp:// and tls:// share their socket code and no call blocks. Not thread-safe.
class TlsSession final : public Sealer {
 public:
  // The client verifies that the certificate belongs to `host`.
  static std::unique_ptr<TlsSession> client(const TlsContext& context, const std::string& host);
  static std::unique_ptr<TlsSession> server(const TlsContext& context);
  ~TlsSession() override;

  // Starts or continues the handshake; appends the bytes to send to `to_send`.
  bool handshake(std::vector<std::byte>& to_send);
  bool established() const;

  // Returns false at the end of the connection; problem() has the reason, or is empty after an orderly close.
  // `to_send` may contain an alert for the other side.
  bool receive(std::span<const std::byte> sealed, std::vector<std::byte>& plain,
               std::vector<std::byte>& to_send);
  bool seal(std::span<const std::byte> plain, std::vector<std::byte>& to) override;

  const std::string& problem() const { return problem_; }

 private:
  explicit TlsSession(ssl_st* ssl);
  void drain(std::vector<std::byte>& to);
  bool fail();

  ssl_st* ssl_;
  std::string problem_;
};

}  // namespace fire3dv::transport::tcp
