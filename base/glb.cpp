#include "base/glb.h"

#include <cstdint>

#include "base/error.h"

namespace fire3dv::base {
namespace {

constexpr uint32_t kMagic = 0x46546c67;        // "glTF"
constexpr uint32_t kJsonChunk = 0x4e4f534a;    // "JSON"
constexpr uint32_t kBinaryChunk = 0x004e4942;  // "BIN\0"
constexpr size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;

constexpr size_t padded(size_t bytes) {
  return (bytes + 3) / 4 * 4;
}

void append_u32(std::vector<std::byte>& to, size_t value) {
  for (int shift = 0; shift < 32; shift += 8) to.push_back(static_cast<std::byte>(value >> shift));
}

void append_chunk(std::vector<std::byte>& to, uint32_t type, std::span<const std::byte> data,
                  std::byte padding) {
  append_u32(to, padded(data.size()));
  append_u32(to, type);
  to.insert(to.end(), data.begin(), data.end());
  to.resize(padded(to.size()), padding);
}

}  // namespace

size_t GlbBuffer::add_view(std::span<const std::byte> bytes, Target target) {
  bytes_.resize(padded(bytes_.size()));
  views_.push_back({bytes_.size(), bytes.size(), target});
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return views_.size() - 1;
}

std::vector<std::byte> make_glb(std::string_view json, std::span<const std::byte> buffer) {
  size_t total = kHeaderBytes + kChunkHeaderBytes + padded(json.size());
  if (!buffer.empty()) total += kChunkHeaderBytes + padded(buffer.size());
  FIRE3DV_ASSERT(total <= UINT32_MAX);
  std::vector<std::byte> glb;
  glb.reserve(total);
  append_u32(glb, kMagic);
  append_u32(glb, 2);
  append_u32(glb, total);
  append_chunk(glb, kJsonChunk, std::as_bytes(std::span(json)), std::byte{' '});
  if (!buffer.empty()) append_chunk(glb, kBinaryChunk, buffer, std::byte{0});
  return glb;
}

}  // namespace fire3dv::base
