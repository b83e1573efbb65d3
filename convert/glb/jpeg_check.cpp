#include "convert/glb/jpeg_check.h"

#include <cstring>

namespace fire3dv::convert {
namespace {

enum : unsigned {
  kEndOfImage = 0xd9,
  kStartOfScan = 0xda,
  kQuantization = 0xdb,
  kHuffman = 0xc4,
  kFirstRestart = 0xd0,
  kLastRestart = 0xd7
};

unsigned at(std::span<const std::byte> bytes, size_t offset) {
  return std::to_integer<unsigned>(bytes[offset]);
}

// Position of the next marker after entropy-coded data, or the size.
size_t after_scan(std::span<const std::byte> bytes, size_t offset) {
  while (offset + 1 < bytes.size()) {
    const void* const found = std::memchr(&bytes[offset], 0xff, bytes.size() - offset - 1);
    if (!found) break;
    offset = static_cast<size_t>(static_cast<const std::byte*>(found) - bytes.data());
    const unsigned next = at(bytes, offset + 1);
    if (next != 0 && next != 0xff && !(next >= kFirstRestart && next <= kLastRestart)) return offset;
    offset += next == 0xff ? 1 : 2;
  }
  return bytes.size();
}

}  // namespace

bool is_sound_jpeg(std::span<const std::byte> bytes) {
  if (bytes.size() < 4 || at(bytes, 0) != 0xff || at(bytes, 1) != 0xd8) return false;
  bool has_frame = false, has_quantization = false, has_huffman = false, has_scan = false;
  for (size_t offset = 2; offset + 1 < bytes.size();) {
    if (at(bytes, offset) != 0xff) return false;
    const unsigned marker = at(bytes, offset + 1);
    if (marker == 0xff) {  // fill byte
      ++offset;
      continue;
    }
    if (marker == kEndOfImage) return has_scan;
    if (offset + 4 > bytes.size()) return false;
    const size_t length = at(bytes, offset + 2) << 8 | at(bytes, offset + 3);
    if (length < 2 || length > bytes.size() - offset - 2) return false;
    const std::span<const std::byte> segment = bytes.subspan(offset + 4, length - 2);
    offset += 2 + length;
    if (marker == kQuantization) {
      has_quantization = true;
    } else if (marker == kHuffman) {
      has_huffman = true;
    } else if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc8 && marker != 0xcc) {
      if (has_frame || marker > 0xc2 || segment.size() < 6) return false;
      const unsigned components = at(segment, 5);
      if (at(segment, 0) != 8 || (components != 1 && components != 3)) return false;
      has_frame = segment.size() == 6 + size_t{3} * components;
      if (!has_frame) return false;
    } else if (marker == kStartOfScan) {
      if (!has_frame || !has_quantization || !has_huffman) return false;
      has_scan = true;
      offset = after_scan(bytes, offset);
    } else if (marker < 0xdd || marker == 0xde || marker == 0xdf) {
      return false;  // arithmetic coding, hierarchical frames, or a marker out of order
    }
  }
  return false;
}

}  // namespace fire3dv::convert
