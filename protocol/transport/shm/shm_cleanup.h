// Removal of segments that killed publishers left in /dev/shm. A file is removed only if it belongs to this
// user, has this layout, and nobody holds the publisher's lock: the lock proves life across PID namespaces,
// where a pid does not.
#pragma once

#include <cstddef>
#include <string>

namespace fire3dv::transport::shm {

// Removes the segment at this path if its publisher is dead. Returns at once, without an error.
bool remove_dead_segment(const std::string& path);

// Same for all segments in /dev/shm, and for the hidden files that a publisher killed while it replaced its
// segment left. Looks at a bounded number of files. except_name: a segment that the caller takes over, so
// that its readers find the next one under the name at any time. Returns how many it removed.
size_t remove_dead_segments(const std::string& except_name = {});

}  // namespace fire3dv::transport::shm
