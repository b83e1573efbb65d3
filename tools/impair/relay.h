// Passes what comes between any number of clients and one target, impairing it on the way, in both directions
// alike.
#pragma once

#include <memory>
#include <string>

#include "protocol/error.h"
#include "tools/impair/impairment.h"

namespace fire3dv::impair {

class Relay {
 public:
  virtual ~Relay() = default;

  virtual void set(const Impairment& impairment) = 0;
  virtual RelayCounts counts() const = 0;
  virtual std::string uri() const = 0;
};

// Listens on `from` (port 0: any) and passes on to `to`: both udp://, or each of tcp:// and tls://, with
// numeric addresses. may_be_public: `from` may be another address than loopback.
Result<std::unique_ptr<Relay>> open_relay(const std::string& from, const std::string& to,
                                          const Impairment& impairment, bool may_be_public);

}  // namespace fire3dv::impair
