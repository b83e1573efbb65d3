// Reader of bits from the least significant one of each byte upwards, as KTX 2.0's codings store them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fire3dv::scene::ktx2 {

class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  // count: 0 .. 32. Past the end the bits are 0, and is_past_end() is true from then on.
  uint32_t bits(uint32_t count) {
    uint32_t value = 0;
    for (uint32_t done = 0; done < count;) {
      const size_t byte = at_ / 8;
      if (byte >= bytes_.size()) {
        is_past_end_ = true;
        return value;
      }
      const auto offset = static_cast<uint32_t>(at_ % 8);
      const uint32_t step = count - done < 8 - offset ? count - done : 8 - offset;
      const uint32_t part = static_cast<uint32_t>(bytes_[byte]) >> offset & ((1u << step) - 1);
      value |= part << done;
      done += step;
      at_ += step;
    }
    return value;
  }

  bool is_past_end() const { return is_past_end_; }

 private:
  std::span<const std::byte> bytes_;
  size_t at_ = 0;  // in bits
  bool is_past_end_ = false;
};

}  // namespace fire3dv::scene::ktx2
