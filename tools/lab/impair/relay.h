// Relay interface: forwards traffic between any number of clients and one target, with impairment in both
// directions. Thread-safe.
#pragma once

#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/transport/core/address.h"
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

}  // namespace fire3dv::impair
