#pragma once

#include <memory>

#include "protocol/error.h"
#include "protocol/transport/address.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"
#include "protocol/transport/uri.h"

namespace fire3dv::transport::udp {

// Hears what is sent to the group, and never sends a byte.
Result<std::unique_ptr<ListenerLink>> make_group_listener(const Uri& uri, const Address& group,
                                                          const ListenerOptions& options);

}  // namespace fire3dv::transport::udp
