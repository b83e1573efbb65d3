// Factory of the publisher of tcp:// and tls:// links: connects to one listener, with retries.
#pragma once

#include <memory>

#include "protocol/base/error.h"
#include "protocol/transport/core/uri.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::tcp {

Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri, const PublisherOptions& options);

}  // namespace fire3dv::transport::tcp
