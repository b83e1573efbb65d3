// A relay for datagrams.
#pragma once

#include <functional>
#include <mutex>
#include <span>

#include "protocol/transport/address.h"
#include "protocol/transport/link_thread.h"
#include "tools/impair/relay.h"

namespace fire3dv::impair {

class UdpRelay final : public Relay {
 public:
  // Listens on `from` (port 0: any) and passes on to `to`; both are udp:// URIs with numeric addresses.
  static Result<std::unique_ptr<UdpRelay>> open(const std::string& from, const std::string& to,
                                                const Impairment& impairment, bool may_be_public = false);
  ~UdpRelay() override;

  void set(const Impairment& impairment) override;
  RelayCounts counts() const override;
  std::string uri() const override { return uri_; }

  // For tests: sees every datagram before its fate is drawn, may change it, and false makes it vanish. Called
  // on the relay's thread; set it before the first datagram comes.
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
