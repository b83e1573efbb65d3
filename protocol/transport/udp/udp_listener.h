#pragma once

#include <memory>

#include "protocol/base/error.h"
#include "protocol/transport/core/uri.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::udp {

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options);

}  // namespace fire3dv::transport::udp
