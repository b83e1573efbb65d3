#include "renderer/gpu/prefault.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <utility>

namespace fire3dv::gpu {
namespace {

constexpr size_t kStep = size_t{1} << 20;  // bytes between checks of the stop token

// Returns false when the system lacks the call or the memory.
bool touch([[maybe_unused]] uintptr_t begin, [[maybe_unused]] uintptr_t end) {
#ifdef MADV_POPULATE_WRITE
  return madvise(reinterpret_cast<void*>(begin), end - begin, MADV_POPULATE_WRITE) == 0;
#else
  return false;
#endif
}

void touch_all(const std::stop_token& stop, const std::vector<std::span<std::byte>>& pieces) {
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  for (const std::span<std::byte> piece : pieces) {
    const auto first = reinterpret_cast<uintptr_t>(piece.data());
    const uintptr_t begin = (first + page - 1) / page * page, end = (first + piece.size()) / page * page;
    for (uintptr_t at = begin; at < end; at += kStep) {
      if (stop.stop_requested() || !touch(at, std::min(at + kStep, end))) return;
    }
  }
}

}  // namespace

std::jthread prefault(std::vector<std::span<std::byte>> pieces) {
  try {
    return std::jthread(touch_all, std::move(pieces));
  } catch (const std::system_error&) {  // without a thread, the device's own writes fault the pages
    return {};
  }
}

}  // namespace fire3dv::gpu
