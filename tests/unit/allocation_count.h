// Counts the heap allocations of the calling thread, whichever function makes them and in whichever library.
// Link allocation_count.cpp into the test program.
#pragma once

#include <cstdint>

namespace fire3dv::test {

uint64_t allocations_of_this_thread();

}  // namespace fire3dv::test
