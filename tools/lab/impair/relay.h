// Relays for TCP streams and UDP datagrams: they forward traffic between any number of clients and one
// target, with impairment in both directions. Thread-safe.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "base/error.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/core/link_thread.h"
#include "tools/lab/impair/impairment.h"

namespace fire3dv::impair {

class Relay {
 public:
  virtual ~Relay() = default;

  virtual void set(const Impairment& impairment) = 0;
  virtual RelayCounts counts() const = 0;
  virtual std::string uri() const = 0;
};

// Listens on `from` (port 0: any) and forwards to `to`. Both are udp://, or each is tcp:// or tls://, with
// numeric addresses. may_be_public: allows addresses other than loopback for `from`.
Result<std::unique_ptr<Relay>> open_relay(const std::string& from, const std::string& to,
                                          const Impairment& impairment, bool may_be_public);

struct RelayEnds {
  std::string uri;  // listening URI with the actual port
  UniqueFd front;
  transport::Address target;
};

// Parses URIs with numeric addresses; port 0 of `from` selects any free one. type: SOCK_DGRAM or SOCK_STREAM.
// may_be_public: allows addresses other than loopback for `from`.
Result<RelayEnds> open_ends(const std::string& from, const std::string& to, int type, bool may_be_public);

// Relay for TCP streams with delay, rate limit, stalls and resets. Payload is not inspected, so that TLS
// passes, too.
class TcpRelay final : public Relay {
 public:
  static Result<std::unique_ptr<TcpRelay>> open(const std::string& from, const std::string& to,
                                                const Impairment& impairment, bool may_be_public = false);
  ~TcpRelay() override;

  // New stall and reset settings apply to later connections.
  void set(const Impairment& impairment) override;
  RelayCounts counts() const override;
  std::string uri() const override { return uri_; }

 private:
  struct State;
  TcpRelay() = default;
  void run();

  std::string uri_;
  std::unique_ptr<State> state_;
  transport::LinkThread thread_;
};

// Relay for UDP datagrams, with the model of DatagramChannel.
class UdpRelay final : public Relay {
 public:
  // Listens on `from` (port 0: any) and forwards to `to`; both are udp:// URIs with numeric addresses.
  static Result<std::unique_ptr<UdpRelay>> open(const std::string& from, const std::string& to,
                                                const Impairment& impairment, bool may_be_public = false);
  ~UdpRelay() override;

  void set(const Impairment& impairment) override;
  RelayCounts counts() const override;
  std::string uri() const override { return uri_; }

  // Test hook: receives every datagram before its fate is drawn and may modify it; false drops it. Called on
  // the relay's thread. Set it before the first datagram arrives.
  using Filter = std::function<bool(bool to_target, std::span<std::byte> datagram)>;
  void set_filter(Filter filter);

 private:
  struct State;
  UdpRelay() = default;
  void run();

  std::string uri_;
  std::unique_ptr<State> state_;
  transport::LinkThread thread_;
};

}  // namespace fire3dv::impair
