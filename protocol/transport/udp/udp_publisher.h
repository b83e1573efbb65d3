#pragma once

#include <memory>

#include "protocol/base/error.h"
#include "protocol/transport/core/uri.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::udp {

Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri, const PublisherOptions& options);

}  // namespace fire3dv::transport::udp
