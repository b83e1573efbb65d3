// Sockets of multicast groups.
#pragma once

#include <optional>

#include "protocol/base/error.h"
#include "protocol/base/unique_fd.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/core/uri.h"

namespace fire3dv::transport::udp {

// The group that the URI names by number; nothing when it is one machine's address, or a name.
std::optional<Address> group_of(const Uri& uri);

// An error for options that only groups have.
Result<void> refuse_group_options(const Uri& uri);

// Sends to the group: connected to it.
Result<UniqueFd> open_group_sender(const Uri& uri, const Address& group);
// Has joined the group, and hears what is sent to it and its port, and nothing else. Any number may.
Result<UniqueFd> open_group_receiver(const Uri& uri, const Address& group);

}  // namespace fire3dv::transport::udp
