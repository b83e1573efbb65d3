// Factory of the listener of shm:// links: reads the segment of one publisher at a time.
#pragma once

#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::shm {

Result<std::unique_ptr<ListenerLink>> make_listener(const std::string& name, const ListenerOptions& options);

}  // namespace fire3dv::transport::shm
