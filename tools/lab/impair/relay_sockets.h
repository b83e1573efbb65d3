// Sockets of a relay: the listening socket and the target address.
#pragma once

#include <string>

#include "protocol/transport/core/address.h"

namespace fire3dv::impair {

struct RelayEnds {
  std::string uri;  // listening URI with the actual port
  UniqueFd front;
  transport::Address target;
};

// Parses URIs with numeric addresses; port 0 of `from` selects any free one. type: SOCK_DGRAM or SOCK_STREAM.
// may_be_public: allows addresses other than loopback for `from`.
Result<RelayEnds> open_ends(const std::string& from, const std::string& to, int type, bool may_be_public);

}  // namespace fire3dv::impair
