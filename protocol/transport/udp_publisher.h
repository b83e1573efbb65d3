#pragma once

#include <memory>

#include "protocol/error.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"
#include "protocol/transport/uri.h"

namespace fire3dv::transport::udp {

Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri, const PublisherOptions& options);

}  // namespace fire3dv::transport::udp
