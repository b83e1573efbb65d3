// While one of these lives, allocations above a size find no memory. Its source replaces operator new of the
// program.
#pragma once

#include <cstddef>

namespace fire3dv::transport::test {

struct NoMemoryAbove {
  explicit NoMemoryAbove(size_t bytes);
  ~NoMemoryAbove();
};

}  // namespace fire3dv::transport::test
