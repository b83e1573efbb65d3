#include "protocol/transport/udp/erasure/erasure_code.h"

#include <algorithm>
#include <array>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace fire3dv::transport::udp {
namespace {

constexpr unsigned kPolynomial = 0x11d;
constexpr size_t kFirstRow = 128;

struct Tables {
  std::array<uint8_t, 512> power{};  // twice, so that sums of logarithms need no modulo
  std::array<uint8_t, 256> logarithm{};
};

constexpr Tables make_tables() {
  Tables tables;
  unsigned value = 1;
  for (size_t i = 0; i < 255; ++i) {
    tables.power[i] = tables.power[i + 255] = static_cast<uint8_t>(value);
    tables.logarithm[value] = static_cast<uint8_t>(i);
    value <<= 1;
    if (value > 255) value ^= kPolynomial;
  }
  return tables;
}
constexpr Tables kTables = make_tables();

// Products of a factor with the low and the high four bits of a byte.
struct NibbleProducts {
  alignas(16) std::array<uint8_t, 16> low{}, high{};
  explicit NibbleProducts(uint8_t factor) {
    for (unsigned i = 0; i < 16; ++i) {
      low[i] = gf_multiply(factor, static_cast<uint8_t>(i));
      high[i] = gf_multiply(factor, static_cast<uint8_t>(i << 4));
    }
  }
  uint8_t of(uint8_t value) const { return low[value & 15] ^ high[value >> 4]; }
};

// Each returns the number of processed bytes, a multiple of 16.
#if defined(__x86_64__)
__attribute__((target("ssse3"))) size_t multiply_add_blocks(uint8_t* sum, const uint8_t* in, size_t bytes,
                                                            const NibbleProducts& products) {
  const __m128i low = _mm_load_si128(reinterpret_cast<const __m128i*>(products.low.data()));
  const __m128i high = _mm_load_si128(reinterpret_cast<const __m128i*>(products.high.data()));
  const __m128i mask = _mm_set1_epi8(15);
  size_t i = 0;
  for (; i + 16 <= bytes; i += 16) {
    const __m128i value = _mm_loadu_si128(reinterpret_cast<const __m128i*>(in + i));
    const __m128i product =
        _mm_xor_si128(_mm_shuffle_epi8(low, _mm_and_si128(value, mask)),
                      _mm_shuffle_epi8(high, _mm_and_si128(_mm_srli_epi64(value, 4), mask)));
    __m128i* const to = reinterpret_cast<__m128i*>(sum + i);
    _mm_storeu_si128(to, _mm_xor_si128(_mm_loadu_si128(to), product));
  }
  return i;
}
bool has_blocks() {
  static const bool has = __builtin_cpu_supports("ssse3") != 0;
  return has;
}
#elif defined(__aarch64__)
size_t multiply_add_blocks(uint8_t* sum, const uint8_t* in, size_t bytes, const NibbleProducts& products) {
  const uint8x16_t low = vld1q_u8(products.low.data()), high = vld1q_u8(products.high.data());
  size_t i = 0;
  for (; i + 16 <= bytes; i += 16) {
    const uint8x16_t value = vld1q_u8(in + i);
    const uint8x16_t product =
        veorq_u8(vqtbl1q_u8(low, vandq_u8(value, vdupq_n_u8(15))), vqtbl1q_u8(high, vshrq_n_u8(value, 4)));
    vst1q_u8(sum + i, veorq_u8(vld1q_u8(sum + i), product));
  }
  return i;
}
constexpr bool has_blocks() {
  return true;
}
#else
size_t multiply_add_blocks(uint8_t*, const uint8_t*, size_t, const NibbleProducts&) {
  return 0;
}
constexpr bool has_blocks() {
  return false;
}
#endif

using Matrix = std::vector<std::vector<uint8_t>>;

// Gauss-Jordan elimination. Every square submatrix of a Cauchy matrix has an inverse.
Matrix invert(Matrix matrix) {
  const size_t size = matrix.size();
  Matrix inverse(size, std::vector<uint8_t>(size));
  for (size_t i = 0; i < size; ++i) inverse[i][i] = 1;
  for (size_t column = 0; column < size; ++column) {
    size_t pivot = column;
    while (matrix[pivot][column] == 0) ++pivot;
    std::swap(matrix[pivot], matrix[column]);
    std::swap(inverse[pivot], inverse[column]);
    const uint8_t scale = gf_inverse(matrix[column][column]);
    for (size_t i = 0; i < size; ++i) {
      matrix[column][i] = gf_multiply(matrix[column][i], scale);
      inverse[column][i] = gf_multiply(inverse[column][i], scale);
    }
    for (size_t row = 0; row < size; ++row) {
      const uint8_t factor = matrix[row][column];
      if (row == column || factor == 0) continue;
      for (size_t i = 0; i < size; ++i) {
        matrix[row][i] ^= gf_multiply(factor, matrix[column][i]);
        inverse[row][i] ^= gf_multiply(factor, inverse[column][i]);
      }
    }
  }
  return inverse;
}

}  // namespace

uint8_t gf_multiply(uint8_t a, uint8_t b) {
  if (a == 0 || b == 0) return 0;
  return kTables.power[size_t{kTables.logarithm[a]} + kTables.logarithm[b]];
}

uint8_t gf_inverse(uint8_t a) {
  return kTables.power[255u - kTables.logarithm[a]];
}

uint8_t parity_factor(size_t row, size_t column) {
  return gf_inverse(static_cast<uint8_t>((kFirstRow + row) ^ column));
}

void gf_multiply_add(std::span<std::byte> sum, std::span<const std::byte> in, uint8_t factor) {
  const NibbleProducts products(factor);
  auto* const to = reinterpret_cast<uint8_t*>(sum.data());
  const auto* const from = reinterpret_cast<const uint8_t*>(in.data());
  size_t i = has_blocks() ? multiply_add_blocks(to, from, in.size(), products) : 0;
  for (; i < in.size(); ++i) to[i] ^= products.of(from[i]);
}

std::vector<std::vector<std::byte>> restore_symbols(const ReceivedSymbols& received) {
  std::vector<size_t> missing, rows;
  for (size_t column = 0; column < received.data.size(); ++column)
    if (received.data[column].empty()) missing.push_back(column);
  for (size_t row = 0; row < received.parity.size() && rows.size() < missing.size(); ++row)
    if (!received.parity[row].empty()) rows.push_back(row);
  if (rows.size() < missing.size()) return {};

  Matrix matrix(missing.size(), std::vector<uint8_t>(missing.size()));
  for (size_t i = 0; i < rows.size(); ++i)
    for (size_t j = 0; j < missing.size(); ++j) matrix[i][j] = parity_factor(rows[i], missing[j]);
  const Matrix inverse = invert(std::move(matrix));

  std::vector<std::vector<std::byte>> restored(missing.size(), std::vector<std::byte>(received.bytes));
  std::vector<std::byte> difference(received.bytes);  // parity without the received data
  for (size_t i = 0; i < rows.size(); ++i) {
    std::ranges::copy(received.parity[rows[i]], difference.begin());
    for (size_t column = 0; column < received.data.size(); ++column)
      gf_multiply_add(difference, received.data[column], parity_factor(rows[i], column));
    for (size_t j = 0; j < missing.size(); ++j) gf_multiply_add(restored[j], difference, inverse[j][i]);
  }
  return restored;
}

}  // namespace fire3dv::transport::udp
