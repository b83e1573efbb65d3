#include "adapters/gazebo/wire/field_count.h"

#include <cstdint>
#include <optional>

namespace fire3dv::gazebo {
namespace {

constexpr int kMaxLevels = 12;  // models within models, and their visuals' maps

std::optional<uint64_t> take_varint(std::span<const std::byte>& bytes) {
  uint64_t value = 0;
  for (unsigned shift = 0; shift < 64 && !bytes.empty(); shift += 7) {
    const auto byte = std::to_integer<uint64_t>(bytes[0]);
    bytes = bytes.subspan(1);
    value |= (byte & 0x7f) << shift;
    if (byte < 0x80) return value;
  }
  return std::nullopt;
}

// Adds the fields to `count`; returns false beyond `most`, and for bytes that are no message.
bool count_fields(std::span<const std::byte> bytes, int level, size_t most, size_t& count) {
  while (!bytes.empty()) {
    const std::optional<uint64_t> tag = take_varint(bytes);
    if (!tag || *tag < 8 || ++count > most) return false;
    size_t size = 0;
    switch (*tag & 7) {
      case 0:
        if (!take_varint(bytes)) return false;
        continue;
      case 1:
        size = 8;
        break;
      case 5:
        size = 4;
        break;
      case 2: {
        const std::optional<uint64_t> length = take_varint(bytes);
        if (!length || *length > bytes.size()) return false;
        size = static_cast<size_t>(*length);
        if (level < kMaxLevels) {
          const size_t before = count;
          if (!count_fields(bytes.first(size), level + 1, most, count)) {
            if (count > most) return false;
            count = before;  // a text
          }
        }
        break;
      }
      default:
        return false;
    }
    if (size > bytes.size()) return false;
    bytes = bytes.subspan(size);
  }
  return true;
}

}  // namespace

bool has_at_most_fields(std::span<const std::byte> message, size_t most) {
  size_t count = 0;
  return count_fields(message, 0, most, count);
}

}  // namespace fire3dv::gazebo
