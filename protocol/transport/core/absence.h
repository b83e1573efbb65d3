// Reason of a failed attempt to connect a link. Unlike PublisherLink::problem() it is no fault: a simulator
// may start before its renderer.
#pragma once

#include <string>

#include "protocol/transport/link.h"

namespace fire3dv::transport {

// Reason of the last attempt to connect, such as "Connection refused"; empty if there is none, or the link
// does not connect.
std::string absence_of(const PublisherLink& link);

}  // namespace fire3dv::transport
