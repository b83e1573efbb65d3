// Relay for UDP datagrams, with the model of DatagramChannel.
#pragma once

#include <functional>
#include <mutex>
#include <span>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/link_thread.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv::impair {

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
