// Systematic Reed-Solomon erasure code over GF(256): up to 64 data symbols of equal length, and up to 64
// parity symbols, of which any as many as data symbols restore all data. Its matrix is a Cauchy matrix; see
// protocol/SPEC-transport.md, section 3.7. No I/O and no state.
//
// Debian's ISA-L has no static library, and the Python wheel and plugins need the client library in one file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fire3dv::transport::udp {

constexpr size_t kMaxDataSymbols = 64;
constexpr size_t kMaxParitySymbols = 64;

// Product in GF(256) with the polynomial x^8 + x^4 + x^3 + x^2 + 1.
uint8_t gf_multiply(uint8_t a, uint8_t b);
uint8_t gf_inverse(uint8_t a);  // a != 0

// Factor of data symbol `column` in parity symbol `row`: 1 / ((128 + row) xor column).
uint8_t parity_factor(size_t row, size_t column);

// sum[i] += factor * in[i]; `in` is at most as long as `sum`.
void gf_multiply_add(std::span<std::byte> sum, std::span<const std::byte> in, uint8_t factor);

// Symbols of one group, by column and by row; empty: absent. Parity symbols have `bytes` bytes; data symbols
// may be shorter and count as padded with zeros.
struct ReceivedSymbols {
  std::vector<std::span<const std::byte>> data;    // one entry per data symbol
  std::vector<std::span<const std::byte>> parity;  // at most kMaxParitySymbols
  size_t bytes = 0;
};

// Restores the absent data symbols, in the order of their columns. Returns nothing if there are too few
// parity symbols.
std::vector<std::vector<std::byte>> restore_symbols(const ReceivedSymbols& received);

}  // namespace fire3dv::transport::udp
