// Passes datagrams between any number of clients and one target, impairing them on the way, in both
// directions alike.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "protocol/error.h"
#include "protocol/transport/address.h"
#include "protocol/transport/link_thread.h"
#include "tools/impair/impairment.h"

namespace fire3dv::impair {

class UdpRelay {
 public:
  // Listens on `from` (port 0: any) and passes on to `to`; both are udp:// URIs with numeric addresses.
  static Result<std::unique_ptr<UdpRelay>> open(const std::string& from, const std::string& to,
                                                const Impairment& impairment);
  ~UdpRelay();

  void set(const Impairment& impairment);
  RelayCounts counts() const;
  std::string uri() const { return uri_; }

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
