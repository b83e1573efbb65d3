#pragma once

#include <memory>

#include "protocol/error.h"
#include "protocol/transport/address.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"
#include "protocol/transport/uri.h"

namespace fire3dv::transport::udp {

// To everybody who has joined the group; nothing comes back.
Result<std::unique_ptr<PublisherLink>> make_group_publisher(const Uri& uri, const Address& group,
                                                            const PublisherOptions& options);

}  // namespace fire3dv::transport::udp
