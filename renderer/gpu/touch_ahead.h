// Memory that a software device is about to write, made present by another core.
#pragma once

#include <cstddef>
#include <span>
#include <thread>
#include <vector>

namespace fire3dv::gpu {

// An operating system gives memory page by page to who writes it first, which takes such a device about as
// long as what it writes. Has the pages of these pieces given, one piece after the other, while somebody else
// may write them; what they hold stays as it is. Ends early when the thread is asked to stop, as its
// destructor does: the memory must live as long as the thread. Where the system knows no way to do so,
// or has no thread left, nothing happens.
std::jthread touch_ahead(std::vector<std::span<std::byte>> pieces);

}  // namespace fire3dv::gpu
