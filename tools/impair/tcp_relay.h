// A relay for TCP streams: they are delayed, slowed, stalled and reset. What they carry is not looked at, so
// TLS passes as well.
#pragma once

#include <mutex>

#include "protocol/transport/link_thread.h"
#include "tools/impair/relay.h"

namespace fire3dv::impair {

class TcpRelay final : public Relay {
 public:
  static Result<std::unique_ptr<TcpRelay>> open(const std::string& from, const std::string& to,
                                                const Impairment& impairment, bool may_be_public = false);
  ~TcpRelay() override;

  // Stalls and resets that are set here hold for connections to come.
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
