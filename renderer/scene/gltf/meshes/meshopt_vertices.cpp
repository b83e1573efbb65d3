#include "renderer/scene/gltf/meshes/meshopt_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace fire3dv::scene {
namespace {

constexpr std::byte kHeaderV1{0xa1};
constexpr size_t kMinTailBytes = 24, kGroup = 16, kMaxBlock = 256, kMaxBlockBytes = 8192;
enum Control { kBits0124, kBits1248, kZeros, kLiterals };
enum ChannelMode { kBytes, kWords, kXor };

uint8_t to_u8(std::byte value) {
  return std::to_integer<uint8_t>(value);
}

// Bytes before the tail. After the end, take() returns null.
class Input {
 public:
  explicit Input(std::span<const std::byte> bytes) : bytes_(bytes) {}
  const std::byte* take(size_t count) {
    if (count > bytes_.size()) return nullptr;
    const std::byte* taken = bytes_.data();
    bytes_ = bytes_.subspan(count);
    return taken;
  }
  bool empty() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

// Sixteen deltas of `bits` each. A delta of ones alone stands for a byte that follows.
bool read_group(Input& in, unsigned bits, uint8_t* deltas) {
  if (bits == 0) {
    std::fill_n(deltas, kGroup, uint8_t{0});
    return true;
  }
  const std::byte* packed = in.take(2 * bits);
  if (packed == nullptr) return false;
  if (bits == 8) {
    std::memcpy(deltas, packed, kGroup);
    return true;
  }
  const unsigned per_byte = 8 / bits, sentinel = (1u << bits) - 1;
  for (unsigned i = 0; i < kGroup; ++i) {
    const unsigned place = i % per_byte;
    // Single bits begin at the lowest, pairs and quadruples at the highest.
    const unsigned shift = bits == 1 ? place : 8 - bits * (place + 1);
    unsigned delta = unsigned{to_u8(packed[i / per_byte])} >> shift & sentinel;
    if (delta == sentinel) {
      const std::byte* whole = in.take(1);
      if (whole == nullptr) return false;
      delta = to_u8(*whole);
    }
    deltas[i] = static_cast<uint8_t>(delta);
  }
  return true;
}

using Lane = std::array<uint8_t, kMaxBlock>;  // one byte of each element of a block

bool read_lane(Input& in, unsigned control, size_t count, Lane& lane) {
  if (control == kZeros) {
    lane.fill(0);
    return true;
  }
  if (control == kLiterals) {
    const std::byte* literals = in.take(count);
    if (literals != nullptr) std::memcpy(lane.data(), literals, count);
    return literals != nullptr;
  }
  static constexpr std::array<unsigned, 5> kBits{0, 1, 2, 4, 8};
  const size_t groups = (count + kGroup - 1) / kGroup;
  const std::byte* modes = in.take((groups + 3) / 4);
  if (modes == nullptr) return false;
  for (size_t group = 0; group < groups; ++group) {
    const unsigned mode = unsigned{to_u8(modes[group / 4])} >> (group % 4 * 2) & 3;
    if (!read_group(in, kBits[control + mode], lane.data() + group * kGroup)) return false;
  }
  return true;
}

template <typename Value>
Value unzigzag(Value v) {
  return static_cast<Value>((v & 1) != 0 ? ~(v >> 1) : v >> 1);
}

// Adds up the deltas of one value of a channel. `value`: of the previous element, on return of the last one.
template <typename Value, typename Combine>
void decode_values(const Lane* lanes, size_t count, size_t stride, std::byte* to, std::byte* value,
                   Combine combine) {
  Value previous;
  std::memcpy(&previous, value, sizeof previous);
  for (size_t i = 0; i < count; ++i, to += stride) {
    uint32_t delta = 0;
    for (size_t b = 0; b < sizeof(Value); ++b) delta |= uint32_t{lanes[b][i]} << (8 * b);
    previous = combine(previous, static_cast<Value>(delta));
    std::memcpy(to, &previous, sizeof previous);
  }
  std::memcpy(value, &previous, sizeof previous);
}

// Four bytes of each element of a block.
bool decode_channel(const Lane* lanes, unsigned mode, size_t count, size_t stride, std::byte* to,
                    std::byte* value) {
  const auto add = [](auto previous, auto delta) {
    return static_cast<decltype(previous)>(previous + unzigzag(delta));
  };
  const unsigned kind = mode & 15, turn = mode >> 4;
  if (kind == kXor) {
    decode_values<uint32_t>(lanes, count, stride, to, value, [turn](uint32_t previous, uint32_t delta) {
      return previous ^ std::rotr(delta, static_cast<int>(turn));
    });
    return true;
  }
  if (turn != 0 || kind > kXor) return false;
  if (kind == kWords) {
    for (size_t b = 0; b < 4; b += 2)
      decode_values<uint16_t>(lanes + b, count, stride, to + b, value + b, add);
  } else {
    for (size_t b = 0; b < 4; ++b) decode_values<uint8_t>(lanes + b, count, stride, to + b, value + b, add);
  }
  return true;
}

template <typename Component>
void decode_colors(std::byte* colors, size_t count) {
  using Signed = std::make_signed_t<Component>;
  constexpr int kMax = static_cast<Component>(-1);
  for (size_t i = 0; i < count; ++i, colors += 4 * sizeof(Component)) {
    std::array<Component, 4> c;
    std::memcpy(c.data(), colors, sizeof c);
    const int scale = (1 << std::bit_width(c[3])) - 1;  // of K bits; 0: invalid
    const int y = c[0], co = static_cast<Signed>(c[1]), cg = static_cast<Signed>(c[2]);
    const int alpha = c[3] & scale >> 1;
    const std::array<int, 4> rgba{y + co - cg, y + cg, y - co - cg, alpha << 1 | (alpha & 1)};
    for (size_t k = 0; k < 4; ++k) {
      const float value = scale == 0 ? 0 : static_cast<float>(rgba[k]) * kMax / static_cast<float>(scale);
      c[k] = static_cast<Component>(std::clamp(std::lround(value), 0L, long{kMax}));
    }
    std::memcpy(colors, c.data(), sizeof c);
  }
}

}  // namespace

bool is_vertex_stream_v1(std::span<const std::byte> stream) {
  return !stream.empty() && stream[0] == kHeaderV1;
}

bool decode_vertices_v1(std::byte* to, size_t count, size_t stride, std::span<const std::byte> stream) {
  const size_t channels = stride / 4, tail = stride + channels;
  const size_t padded_tail = std::max(tail, kMinTailBytes);
  if (!is_vertex_stream_v1(stream) || stream.size() - 1 < padded_tail) return false;
  std::array<std::byte, 256> element;  // the previous one, at first the baseline
  std::memcpy(element.data(), stream.last(tail).data(), stride);
  const auto modes = stream.last(channels);
  Input in(stream.subspan(1, stream.size() - 1 - padded_tail));
  const size_t max_block = std::min(kMaxBlockBytes / stride / kGroup * kGroup, kMaxBlock);
  std::array<Lane, 4> lanes;
  for (size_t first = 0; first < count; first += max_block) {
    const size_t block = std::min(max_block, count - first);
    const std::byte* controls = in.take(channels);
    if (controls == nullptr) return false;
    for (size_t channel = 0; channel < channels; ++channel) {
      for (size_t b = 0; b < 4; ++b) {
        const unsigned control = unsigned{to_u8(controls[channel])} >> (2 * b) & 3;
        if (!read_lane(in, control, block, lanes[b])) return false;
      }
      if (!decode_channel(lanes.data(), to_u8(modes[channel]), block, stride,
                          to + first * stride + channel * 4, element.data() + channel * 4)) {
        return false;
      }
    }
  }
  return in.empty();
}

void decode_color_filter(std::byte* colors, size_t count, size_t component_bytes) {
  if (component_bytes == 1) {
    decode_colors<uint8_t>(colors, count);
  } else {
    decode_colors<uint16_t>(colors, count);
  }
}

}  // namespace fire3dv::scene
