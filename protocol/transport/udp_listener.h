#pragma once

#include <memory>

#include "protocol/error.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"
#include "protocol/transport/uri.h"

namespace fire3dv::transport::udp {

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options);

}  // namespace fire3dv::transport::udp
