#pragma once

#include <memory>
#include <string>

#include "protocol/error.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::shm {

Result<std::unique_ptr<PublisherLink>> make_publisher(const std::string& name,
                                                      const PublisherOptions& options);

}  // namespace fire3dv::transport::shm
