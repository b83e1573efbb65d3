// Copies of bytes that another process may write or read meanwhile. What a copy got is believed only when the
// slot's sequence says that nobody wrote during it (shm_ring.cpp).
//
// C++ has no words for this yet: plain copies are a data race, and atomics are words of at most 8 bytes,
// which compilers do not put together: such a loop takes four times as long as memcpy. What is meant is the
// byte-wise atomic memcpy of WG21 paper P1478, and as that paper says it may be done, on the machines named
// below, by memcpy itself: each byte is loaded or stored by some instruction, a torn value is a value, and
// the fences around the copy order those instructions like any others. Two things have to be kept from the
// compiler, which may reason that nobody else looks at plain memory: it does not see that it is memcpy that
// is called, and it may not move memory accesses over the call. And one from the library: very large copies
// may use stores that bypass the caches and their order, so a copy is made in pieces below that size.
//
// On other machines, and for ThreadSanitizer, which is to see who synchronises with whom, the copy is one of
// relaxed atomic words.
#pragma once

#include <cstddef>

namespace fire3dv::transport::shm {

// Shared memory consists of whole 8-byte words.
void copy_to_shared(std::byte* shared, const std::byte* from, size_t bytes);
// `shared` is 8-byte aligned.
void copy_from_shared(std::byte* to, const std::byte* shared, size_t bytes);

}  // namespace fire3dv::transport::shm
