// Replacement of operator new with a size limit.
#include "tests/unit/protocol/transport/allocation_fault.h"

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace {
std::atomic<size_t> largest_allocation{SIZE_MAX};
}

namespace fire3dv::transport::test {

ScopedAllocationLimit::ScopedAllocationLimit(size_t bytes) {
  largest_allocation = bytes;
}
ScopedAllocationLimit::~ScopedAllocationLimit() {
  largest_allocation = SIZE_MAX;
}

}  // namespace fire3dv::transport::test

void* operator new(size_t bytes) {
  if (bytes > largest_allocation.load(std::memory_order_relaxed)) throw std::bad_alloc();
  if (void* memory = std::malloc(bytes != 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}
void* operator new(size_t bytes, const std::nothrow_t&) noexcept {
  if (bytes > largest_allocation.load(std::memory_order_relaxed)) return nullptr;
  return std::malloc(bytes != 0 ? bytes : 1);
}
// Not inlined: GCC would see free() of what operator new returned.
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, const std::nothrow_t&) noexcept {
  std::free(memory);
}
