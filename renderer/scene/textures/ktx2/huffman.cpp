#include "renderer/scene/textures/ktx2/huffman.h"

#include <algorithm>

namespace fire3dv::scene::ktx2 {
namespace {

constexpr uint32_t kLengthSymbols = 21;
constexpr std::array<uint8_t, kLengthSymbols> kLengthOrder{17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                           11, 4,  12, 3,  13, 2, 14, 1, 15, 16};
// Symbols above 16 of the code of lengths: runs of zeros, and runs of the previous length.
struct Run {
  uint32_t extra_bits, least;
  bool repeats;
};
constexpr std::array<Run, 4> kRuns{{{3, 3, false}, {7, 11, false}, {2, 3, true}, {7, 7, true}}};

}  // namespace

std::optional<HuffmanCode> HuffmanCode::from_lengths(std::span<const uint8_t> lengths) {
  HuffmanCode code;
  for (const uint8_t length : lengths) {
    if (length > kMaxBits) return std::nullopt;
    if (length > 0) ++code.count_[length];
  }
  uint64_t used = 0;  // of 2^16 codes of full length
  std::array<uint32_t, kMaxBits + 1> next{};
  for (uint32_t bits = 1; bits <= kMaxBits; ++bits) {
    used += uint64_t{code.count_[bits]} << (kMaxBits - bits);
    next[bits] = next[bits - 1] + code.count_[bits - 1];
  }
  if (used > uint64_t{1} << kMaxBits) return std::nullopt;
  code.symbols_.resize(next[kMaxBits] + code.count_[kMaxBits]);
  for (size_t symbol = 0; symbol < lengths.size(); ++symbol) {
    if (lengths[symbol] > 0) code.symbols_[next[lengths[symbol]]++] = static_cast<uint16_t>(symbol);
  }
  return code;
}

std::optional<HuffmanCode> HuffmanCode::read(BitReader& reader) {
  const uint32_t symbol_count = reader.bits(14);
  if (symbol_count == 0) return HuffmanCode();  // of a coding that the file does not use
  const uint32_t length_codes = reader.bits(5);
  if (length_codes < 1 || length_codes > kLengthSymbols) return std::nullopt;
  std::array<uint8_t, kLengthSymbols> length_lengths{};
  for (uint32_t i = 0; i < length_codes; ++i)
    length_lengths[kLengthOrder[i]] = static_cast<uint8_t>(reader.bits(3));
  const std::optional<HuffmanCode> length_code = from_lengths(length_lengths);
  if (!length_code) return std::nullopt;

  std::vector<uint8_t> lengths;
  lengths.reserve(symbol_count);
  while (lengths.size() < symbol_count) {
    const std::optional<uint32_t> symbol = length_code->decode(reader);
    if (!symbol) return std::nullopt;
    if (*symbol <= kMaxBits) {
      lengths.push_back(static_cast<uint8_t>(*symbol));
      continue;
    }
    const Run& run = kRuns[*symbol - kMaxBits - 1];
    const size_t length = run.least + reader.bits(run.extra_bits);
    if (length > symbol_count - lengths.size()) return std::nullopt;
    if (run.repeats && (lengths.empty() || lengths.back() == 0)) return std::nullopt;
    lengths.insert(lengths.end(), length, run.repeats ? lengths.back() : uint8_t{0});
  }
  if (reader.is_past_end()) return std::nullopt;
  return from_lengths(lengths);
}

std::optional<uint32_t> HuffmanCode::decode(BitReader& reader) const {
  // Codes of one length are consecutive numbers; the first follows from the counts of shorter ones.
  uint32_t code = 0, first = 0, index = 0;
  for (uint32_t bits = 1; bits <= kMaxBits; ++bits) {
    code |= reader.bits(1);
    if (reader.is_past_end()) return std::nullopt;
    const uint32_t count = count_[bits];
    if (code - first < count) return symbols_[index + (code - first)];
    index += count;
    first = (first + count) << 1;
    code <<= 1;
  }
  return std::nullopt;
}

}  // namespace fire3dv::scene::ktx2
