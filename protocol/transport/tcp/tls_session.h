// TLS 1.3 over bytes that somebody else carries: what comes from the socket goes in, what must go to the
// socket comes out. So the same sending and receiving serves tcp:// and tls://, and nothing in here can wait.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/transport/open.h"
#include "protocol/transport/tcp/tcp_outbox.h"

struct ssl_ctx_st;
struct ssl_st;

namespace fire3dv::transport::tcp {

// Certificates and keys, read once when the link is opened. Null for tcp://.
using TlsContext = std::shared_ptr<ssl_ctx_st>;
Result<TlsContext> make_server_context(const std::string& uri, const TlsListenerOptions& options);
Result<TlsContext> make_client_context(const std::string& uri, const TlsPublisherOptions& options);

// One connection. Not thread-safe.
class TlsSession final : public Sealer {
 public:
  // The client's end checks that the certificate is `host`'s.
  static std::unique_ptr<TlsSession> client(const TlsContext& context, const std::string& host);
  static std::unique_ptr<TlsSession> server(const TlsContext& context);
  ~TlsSession() override;

  // Sets the handshake going, or carries it on; appends what has to be sent to `to_send`.
  bool handshake(std::vector<std::byte>& to_send);
  bool established() const;

  // False: the connection cannot go on, and problem() says why unless the other side closed it in order;
  // `to_send` may hold the alert that tells the other side.
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
