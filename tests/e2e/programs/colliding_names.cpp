// Inversion of libstdc++'s string hash (MurmurHash64A) for equal-length names.
#include "tests/e2e/programs/colliding_names.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <functional>
#include <random>

namespace fire3dv::test {
namespace {

static_assert(std::endian::native == std::endian::little);

// Parameters of libstdc++'s _Hash_bytes: MurmurHash64A. Each step is a bijection of 64-bit numbers.
constexpr uint64_t kSeed = 0xc70f6907;
constexpr uint64_t kMultiplier = (uint64_t{0xc6a4a793} << 32) + 0x5bd1e995;
constexpr size_t kNameBytes = 16;

constexpr uint64_t inverse(uint64_t odd) {
  uint64_t result = odd;  // correct in the lowest 3 bits; each Newton step doubles the number of correct bits
  for (int i = 0; i < 5; ++i) result *= 2 - odd * result;
  return result;
}

constexpr uint64_t shift_mix(uint64_t v) {
  return v ^ (v >> 47);  // an involution, since 2 * 47 > 64
}
constexpr uint64_t mix(uint64_t block) {
  return shift_mix(block * kMultiplier) * kMultiplier;
}
constexpr uint64_t unmix(uint64_t mixed) {
  return shift_mix(mixed * inverse(kMultiplier)) * inverse(kMultiplier);
}
static_assert(unmix(mix(0x0123456789abcdef)) == 0x0123456789abcdef);

// True if all eight bytes are letters, digits or punctuation. '/' and '~' are excluded: they have a meaning
// in node paths.
bool is_printable(uint64_t block) {
  for (int i = 0; i < 8; ++i) {
    const auto byte = static_cast<uint8_t>(block >> (8 * i));
    if (byte <= ' ' || byte >= '~' || byte == '/') return false;
  }
  return true;
}

}  // namespace

std::vector<std::string> colliding_names(size_t count) {
  constexpr uint64_t kTarget = 0x243f6a8885a308d3;  // any state after both blocks
  std::mt19937_64 generator(1);
  std::vector<std::string> names;
  while (names.size() < count) {
    uint64_t first = 0;
    for (int i = 0; i < 8; ++i) first = first << 8 | (0x61 + generator() % 26);
    const uint64_t after_first = ((kSeed ^ (kNameBytes * kMultiplier)) ^ mix(first)) * kMultiplier;
    const uint64_t second = unmix(after_first ^ kTarget);
    if (!is_printable(second)) continue;
    std::string name(kNameBytes, '\0');
    std::memcpy(name.data(), &first, 8);
    std::memcpy(name.data() + 8, &second, 8);
    names.push_back(std::move(name));
    if (std::hash<std::string>{}(names.back()) != std::hash<std::string>{}(names.front())) return {};
  }
  return names;
}

}  // namespace fire3dv::test
