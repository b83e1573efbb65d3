// TLS 1.3 session without socket I/O: the caller passes received bytes and sends the produced ones, so that
// tcp:// and tls:// share their socket code and no call blocks.
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
