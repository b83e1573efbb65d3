#pragma once

#include <memory>

#include "protocol/base/error.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/core/uri.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::udp {

// Hears what is sent to the group, and never sends a byte.
Result<std::unique_ptr<ListenerLink>> make_group_listener(const Uri& uri, const Address& group,
                                                          const ListenerOptions& options);

}  // namespace fire3dv::transport::udp
