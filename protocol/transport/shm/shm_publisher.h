// Factory of the publisher of shm:// links: owns one segment, which any number of readers attach to.
#pragma once

#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::shm {

Result<std::unique_ptr<PublisherLink>> make_publisher(const std::string& name,
                                                      const PublisherOptions& options);

}  // namespace fire3dv::transport::shm
