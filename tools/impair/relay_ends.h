// Where a relay listens, and where to it passes on.
#pragma once

#include <string>

#include "protocol/transport/address.h"

namespace fire3dv::impair {

struct RelayEnds {
  std::string uri;  // of the listening end, with the port that was chosen
  transport::UniqueFd front;
  transport::Address target;
};

// Both are URIs with numeric addresses; `from` may have port 0: any. type: SOCK_DGRAM or SOCK_STREAM.
// may_be_public: `from` may be another address than loopback.
Result<RelayEnds> open_ends(const std::string& from, const std::string& to, int type, bool may_be_public);

}  // namespace fire3dv::impair
