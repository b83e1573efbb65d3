// Fault injection for memory: while an object lives, larger allocations throw std::bad_alloc. Its source file
// replaces the program's operator new.
#pragma once

#include <cstddef>

namespace fire3dv::transport::test {

struct ScopedAllocationLimit {
  explicit ScopedAllocationLimit(size_t bytes);
  ~ScopedAllocationLimit();
};

}  // namespace fire3dv::transport::test
