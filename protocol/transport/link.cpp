#include "protocol/transport/link.h"

namespace fire3dv::transport {

const char* cause_name(Cause cause) {
  constexpr const char* kNames[] = {"malformed", "version",         "oversize", "full",
                                    "silent",    "unknown_session", "replayed", "bad_key",
                                    "unread",    "no_memory",       "lapped",   "system"};
  static_assert(std::size(kNames) == kCauseCount);
  return kNames[static_cast<size_t>(cause)];
}

Result<void> PublisherLink::make_room_for_images(size_t, size_t) {
  return Error{"images do not come back over this link; use shm:// or tcp://"};
}

}  // namespace fire3dv::transport
