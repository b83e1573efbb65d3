#pragma once

#include <memory>

#include "protocol/base/error.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/core/uri.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::udp {

// To everybody who has joined the group; nothing comes back. numbers_before_anew: see Carousel.
Result<std::unique_ptr<PublisherLink>> make_group_publisher(const Uri& uri, const Address& group,
                                                            const PublisherOptions& options,
                                                            uint32_t numbers_before_anew = uint32_t{1} << 31);

}  // namespace fire3dv::transport::udp
