// Pre-faulting of memory that a software device is about to write. A background thread populates the pages.
#pragma once

#include <cstddef>
#include <span>
#include <thread>
#include <vector>

namespace fire3dv::gpu {

// Populates the pages of each piece in order; other threads may write them meanwhile, and their content
// stays. Reason: an operating system needs about as long for a first-touch page fault as such a device for
// the write itself. The thread ends early on a stop request, as its destructor sends one; the memory must
// outlive it. Without system support or a free thread the call has no effect.
std::jthread prefault(std::vector<std::span<std::byte>> pieces);

}  // namespace fire3dv::gpu
