// Memory layout of an image, in network messages and in shared memory: request, header (an encoded
// ImageFrame), pixels. The header can be read without a copy of the pixels.
//
//   0  u64  request     links queue the newest image of each
//   8  u32  head bytes  12  u32  0
//  16  head | zeros up to a multiple of 64 | pixels
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/base/error.h"

namespace fire3dv::wire {

constexpr size_t kImageBlockHeaderBytes = 16;
// Upper bound of a header: 9 planes and the other fields.
constexpr size_t kMaxImageHeadBytes = 1024;

constexpr size_t pixels_at(size_t head_bytes) {
  return (kImageBlockHeaderBytes + head_bytes + 63) / 64 * 64;
}
// Sufficient for any header.
constexpr size_t max_block_bytes(size_t pixel_bytes) {
  return pixels_at(kMaxImageHeadBytes) + pixel_bytes;
}

// Writes everything except the pixels; `block` has at least pixels_at(head.size()) bytes.
void write_image_block_head(std::span<std::byte> block, uint64_t request, std::span<const std::byte> head);

struct ImageBlock {
  uint64_t request = 0;
  std::span<const std::byte> head, pixels;
};
// Views of `block`, consistent and inside `block` even while another process writes to it. The caller must
// decode the header from a private copy and validate it against the number of pixel bytes.
Result<ImageBlock> read_image_block(std::span<const std::byte> block);

}  // namespace fire3dv::wire
