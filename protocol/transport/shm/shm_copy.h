// Seqlock payload copies from and to shared memory that another process may access concurrently. The caller
// discards the result if the slot's sequence number changed (shm_ring.cpp).
//
// Implements the byte-wise atomic memcpy of WG21 paper P1478: memcpy on the machines that shm_copy.cpp names,
// relaxed atomic words on others and for ThreadSanitizer. Reasons: docs/design/shared-memory.md.
#pragma once

#include <cstddef>

namespace fire3dv::transport::shm {

// Shared memory is a whole number of 8-byte words.
void copy_to_shared(std::byte* shared, const std::byte* from, size_t bytes);
// `shared` must be 8-byte aligned.
void copy_from_shared(std::byte* to, const std::byte* shared, size_t bytes);

}  // namespace fire3dv::transport::shm
