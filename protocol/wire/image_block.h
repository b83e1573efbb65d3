// How an image lies in memory, in a message of a network link as in shared memory: who asked for it, its head
// (an encoded ImageFrame), and behind that the pixels, which nobody copies to look at the head.
//
//   0  u64  request     links keep the newest image of each
//   8  u32  head bytes  12  u32  0
//  16  head | zeros up to a multiple of 64 | pixels
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/error.h"

namespace fire3dv::wire {

constexpr size_t kImageBlockHeaderBytes = 16;
// A head is this long at most: 9 planes and the rest.
constexpr size_t kMostImageHeadBytes = 1024;

constexpr size_t pixels_at(size_t head_bytes) {
  return (kImageBlockHeaderBytes + head_bytes + 63) / 64 * 64;
}
// Enough for any head.
constexpr size_t most_block_bytes(size_t pixel_bytes) {
  return pixels_at(kMostImageHeadBytes) + pixel_bytes;
}

// Writes all but the pixels; `block` holds pixels_at(head.size()) bytes or more.
void write_image_block_head(std::span<std::byte> block, uint64_t request, std::span<const std::byte> head);

struct ImageBlock {
  uint64_t request = 0;
  std::span<const std::byte> head, pixels;
};
// Views of `block`, consistent with each other and inside `block` even while another process changes it. The
// head itself has to be decoded from a private copy, and what it says of the pixels checked against their
// number.
Result<ImageBlock> read_image_block(std::span<const std::byte> block);

}  // namespace fire3dv::wire
