// Relay for TCP streams with delay, rate limit, stalls and resets. Payload is not inspected, so that TLS
// passes, too.
#pragma once

#include <mutex>

#include "protocol/transport/core/link_thread.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv::impair {

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

}  // namespace fire3dv::impair
