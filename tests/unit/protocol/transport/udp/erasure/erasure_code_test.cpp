// Reed-Solomon code of parity datagrams: field arithmetic, and restoration for every pattern of losses.
#include "protocol/transport/udp/erasure/erasure_code.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <random>
#include <vector>

namespace fire3dv::transport::test {
namespace {

using Symbol = std::vector<std::byte>;

std::vector<Symbol> random_symbols(size_t count, size_t bytes) {
  static std::mt19937 generator(5);
  std::vector<Symbol> symbols(count, Symbol(bytes));
  for (Symbol& symbol : symbols)
    for (std::byte& byte : symbol) byte = static_cast<std::byte>(generator());
  return symbols;
}

std::vector<Symbol> parity_of(const std::vector<Symbol>& data, size_t rows, size_t bytes) {
  std::vector<Symbol> parity(rows, Symbol(bytes));
  for (size_t row = 0; row < rows; ++row)
    for (size_t column = 0; column < data.size(); ++column)
      udp::gf_multiply_add(parity[row], data[column], udp::parity_factor(row, column));
  return parity;
}

TEST(ErasureCode, FieldIsThatOfTheSpecification) {
  EXPECT_EQ(udp::gf_multiply(0x80, 2), 0x1d);
  EXPECT_EQ(udp::parity_factor(0, 0), 0x1b);
  EXPECT_EQ(udp::parity_factor(0, 63), 0xb6);
  EXPECT_EQ(udp::parity_factor(1, 0), 0x54);
  for (unsigned a = 1; a < 256; ++a)
    EXPECT_EQ(udp::gf_multiply(static_cast<uint8_t>(a), udp::gf_inverse(static_cast<uint8_t>(a))), 1) << a;
}

// Blocks of the processor's vector instructions, and the rest.
TEST(ErasureCode, AllLengthsAndFactorsMultiply) {
  for (unsigned factor = 0; factor < 256; ++factor) {
    for (const size_t bytes : {0u, 1u, 15u, 16u, 17u, 47u}) {
      const std::vector<Symbol> in = random_symbols(2, bytes);
      Symbol sum = in[0], expected = in[0];
      for (size_t i = 0; i < bytes; ++i)
        expected[i] ^= static_cast<std::byte>(
            udp::gf_multiply(static_cast<uint8_t>(factor), std::to_integer<uint8_t>(in[1][i])));
      udp::gf_multiply_add(sum, in[1], static_cast<uint8_t>(factor));
      ASSERT_EQ(sum, expected) << factor << " " << bytes;
    }
  }
}

TEST(ErasureCode, EveryPatternOfLossesIsRestored) {
  constexpr size_t kBytes = 21;
  for (size_t data_count = 1; data_count <= 6; ++data_count) {
    for (size_t parity_count = 1; parity_count <= 4; ++parity_count) {
      const std::vector<Symbol> data = random_symbols(data_count, kBytes);
      const std::vector<Symbol> parity = parity_of(data, parity_count, kBytes);
      const size_t all = data_count + parity_count;
      for (uint32_t received = 0; received < 1u << all; ++received) {
        udp::ReceivedSymbols symbols;
        symbols.bytes = kBytes;
        std::vector<Symbol> lost;
        for (size_t i = 0; i < all; ++i) {
          const bool is_here = (received >> i & 1) != 0;
          const Symbol& symbol = i < data_count ? data[i] : parity[i - data_count];
          (i < data_count ? symbols.data : symbols.parity)
              .push_back(is_here ? std::span<const std::byte>(symbol) : std::span<const std::byte>());
          if (i < data_count && !is_here) lost.push_back(symbol);
        }
        const bool is_enough = static_cast<size_t>(std::popcount(received)) >= data_count;
        const auto restored = udp::restore_symbols(symbols);
        ASSERT_EQ(restored, is_enough ? lost : std::vector<Symbol>()) << data_count << " " << received;
      }
    }
  }
}

TEST(ErasureCode, LargestGroupIsRestoredFromParityAlone) {
  const std::vector<Symbol> data = random_symbols(udp::kMaxDataSymbols, 40);
  const std::vector<Symbol> parity = parity_of(data, udp::kMaxParitySymbols, 40);
  udp::ReceivedSymbols symbols;
  symbols.bytes = 40;
  symbols.data.resize(udp::kMaxDataSymbols);
  symbols.parity.assign(parity.begin(), parity.end());
  EXPECT_EQ(udp::restore_symbols(symbols), data);
}

}  // namespace
}  // namespace fire3dv::transport::test
