// Counter of the calling thread's heap allocations, through any function and library. Link
// allocation_count.cpp into the test program.
#pragma once

#include <cstdint>

namespace fire3dv::test {

uint64_t allocations_of_this_thread();

}  // namespace fire3dv::test
