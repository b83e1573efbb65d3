#include "protocol/wire/image.h"

#include <bit>
#include <cstring>

namespace fire3dv::wire {

static_assert(std::endian::native == std::endian::little, "blocks are little-endian");

void write_image_block_head(std::span<std::byte> block, uint64_t request, std::span<const std::byte> head) {
  const size_t end = pixels_at(head.size());
  FIRE3DV_ASSERT(head.size() <= kMaxImageHeadBytes && block.size() >= end);
  const auto head_bytes = static_cast<uint32_t>(head.size());
  std::memset(block.data(), 0, end);
  std::memcpy(block.data(), &request, sizeof request);
  std::memcpy(block.data() + 8, &head_bytes, sizeof head_bytes);
  std::memcpy(block.data() + kImageBlockHeaderBytes, head.data(), head.size());
}

namespace {

// Copies bytes that another process may write concurrently: each byte is read once.
void copy_once(std::byte* to, const std::byte* shared, size_t bytes) {
  const auto* from = reinterpret_cast<const unsigned char*>(shared);  // clang's builtin takes integers only
  for (size_t i = 0; i < bytes; ++i) to[i] = std::byte{__atomic_load_n(from + i, __ATOMIC_RELAXED)};
}

}  // namespace

Result<ImageBlock> read_image_block(std::span<const std::byte> block) {
  if (block.size() < kImageBlockHeaderBytes)
    return Error{"an image has " + std::to_string(block.size()) + " bytes; the smallest has more"};
  std::byte header[kImageBlockHeaderBytes];
  copy_once(header, block.data(), sizeof header);
  ImageBlock result;
  uint32_t head_bytes = 0;
  std::memcpy(&result.request, header, sizeof result.request);
  std::memcpy(&head_bytes, header + 8, sizeof head_bytes);
  if (head_bytes > kMaxImageHeadBytes || pixels_at(head_bytes) > block.size())
    return Error{"an image's head has " + std::to_string(head_bytes) + " bytes, which do not lie in its " +
                 std::to_string(block.size())};
  result.head = block.subspan(kImageBlockHeaderBytes, head_bytes);
  result.pixels = block.subspan(pixels_at(head_bytes));
  return result;
}

}  // namespace fire3dv::wire
