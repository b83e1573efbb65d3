// Sockets of multicast groups.
#pragma once

#include <optional>

#include "base/error.h"
#include "base/unique_fd.h"
#include "protocol/transport/core/address.h"

namespace fire3dv::transport::udp {

// Multicast address of the URI, or nothing for a unicast address or a host name.
std::optional<Address> group_of(const Uri& uri);

// Returns an error if the URI has options that only multicast groups support.
Result<void> refuse_group_options(const Uri& uri);

// Opens a socket that is connected to the group.
Result<UniqueFd> open_group_sender(const Uri& uri, const Address& group);
// Opens a socket that has joined the group and receives only its traffic. Several sockets may share a port.
Result<UniqueFd> open_group_receiver(const Uri& uri, const Address& group);

}  // namespace fire3dv::transport::udp
