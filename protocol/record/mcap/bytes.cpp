#include "protocol/record/mcap/bytes.h"

#include <lz4frame.h>
#include <zstd.h>

#include <array>
#include <cstring>

#if defined(__x86_64__) && defined(__GNUC__)
#define FIRE3DV_CRC_BY_PRODUCTS
#include <immintrin.h>
#endif

namespace fire3dv::record {
namespace {

// Higher levels hardly reduce the size of poses and take several times as long.
constexpr int kZstdLevel = 1;

// Slicing-by-16 tables: table k holds the CRC of a byte followed by k zero bytes.
constexpr size_t kStep = 16;
using Tables = std::array<std::array<uint32_t, 256>, kStep>;

constexpr Tables make_tables() {
  Tables tables{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
    tables[0][i] = crc;
  }
  for (size_t k = 1; k < kStep; ++k)
    for (size_t i = 0; i < 256; ++i)
      tables[k][i] = tables[k - 1][i] >> 8 ^ tables[0][tables[k - 1][i] & 0xff];
  return tables;
}

constexpr Tables kTables = make_tables();

#ifdef FIRE3DV_CRC_BY_PRODUCTS
// x^bits modulo the polynomial, bit-reflected, as carry-less multiplication of reflected polynomials
// requires.
constexpr uint64_t power(unsigned bits) {
  uint32_t remainder = 0x80000000u;  // the polynomial 1, reflected
  for (unsigned i = 0; i < bits; ++i)
    remainder = remainder & 1 ? remainder >> 1 ^ 0xedb88320u : remainder >> 1;
  return uint64_t{remainder} << 1;
}

// Folds the 16-byte remainder forward by `bits` onto the next 16 bytes: two carry-less multiplications.
__attribute__((target("pclmul,sse4.1"))) inline __m128i fold(__m128i sum, __m128i powers, __m128i next) {
  return _mm_xor_si128(
      _mm_xor_si128(_mm_clmulepi64_si128(sum, powers, 0x00), _mm_clmulepi64_si128(sum, powers, 0x11)), next);
}

// Folds all whole 64-byte blocks into 16 bytes with the same CRC. The table method then processes these.
__attribute__((target("pclmul,sse4.1"))) std::array<uint8_t, 16> fold_all(const uint8_t*& at, size_t& left,
                                                                          uint32_t crc) {
  const auto load = [](const uint8_t* from) __attribute__((target("pclmul,sse4.1"))) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
  };
  constexpr uint64_t kOver512[] = {power(512 + 32), power(512 - 32)};
  constexpr uint64_t kOver128[] = {power(128 + 32), power(128 - 32)};
  const __m128i over_512 = load(reinterpret_cast<const uint8_t*>(kOver512));
  const __m128i over_128 = load(reinterpret_cast<const uint8_t*>(kOver128));
  __m128i sums[4];
  for (size_t i = 0; i < 4; ++i) sums[i] = load(at + 16 * i);
  sums[0] = _mm_xor_si128(sums[0], _mm_cvtsi32_si128(static_cast<int>(crc)));
  for (at += 64, left -= 64; left >= 64; at += 64, left -= 64)
    for (size_t i = 0; i < 4; ++i) sums[i] = fold(sums[i], over_512, load(at + 16 * i));
  for (size_t i = 1; i < 4; ++i) sums[i] = fold(sums[i - 1], over_128, sums[i]);
  std::array<uint8_t, 16> result;
  _mm_storeu_si128(reinterpret_cast<__m128i*>(result.data()), sums[3]);
  return result;
}

const bool kHasProducts = __builtin_cpu_supports("pclmul") && __builtin_cpu_supports("sse4.1");
#endif

uint32_t by_tables(const uint8_t* at, size_t left, uint32_t crc) {
  for (; left >= kStep; at += kStep, left -= kStep) {
    uint32_t next = 0;
    for (size_t i = 0; i < 4; ++i) next ^= kTables[kStep - 1 - i][(crc >> 8 * i & 0xff) ^ at[i]];
    for (size_t i = 4; i < kStep; ++i) next ^= kTables[kStep - 1 - i][at[i]];
    crc = next;
  }
  for (; left > 0; ++at, --left) crc = crc >> 8 ^ kTables[0][(crc & 0xff) ^ *at];
  return crc;
}

}  // namespace

uint32_t crc32(std::span<const std::byte> bytes, uint32_t before) {
  uint32_t crc = ~before;
  const auto* at = reinterpret_cast<const uint8_t*>(bytes.data());
  size_t left = bytes.size();
#ifdef FIRE3DV_CRC_BY_PRODUCTS
  if (left >= 128 && kHasProducts) {
    const std::array<uint8_t, 16> sum = fold_all(at, left, crc);
    crc = by_tables(sum.data(), sum.size(), 0);
  }
#endif
  return ~by_tables(at, left, crc);
}

std::string_view compression_name(Compression compression) {
  switch (compression) {
    case Compression::none:
      return "";
    case Compression::zstd:
      return "zstd";
    case Compression::lz4:
      return "lz4";
  }
  return "";
}

std::optional<Compression> compression_of(std::string_view name) {
  for (const Compression each : {Compression::none, Compression::zstd, Compression::lz4})
    if (compression_name(each) == name) return each;
  return std::nullopt;
}

uint64_t max_compressed_bytes(uint64_t uncompressed_bytes) {
  return uncompressed_bytes + uncompressed_bytes / 128 + 4096;
}

struct Compressor::Impl {
  ZSTD_CCtx* pack = nullptr;
  ZSTD_DCtx* unpack = nullptr;
  LZ4F_dctx* unpack_lz4 = nullptr;
  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    ZSTD_freeCCtx(pack);
    ZSTD_freeDCtx(unpack);
    if (unpack_lz4) LZ4F_freeDecompressionContext(unpack_lz4);
  }
};

Compressor::Compressor() : impl_(std::make_unique<Impl>()) {}
Compressor::~Compressor() = default;
Compressor::Compressor(Compressor&&) noexcept = default;
Compressor& Compressor::operator=(Compressor&&) noexcept = default;

bool Compressor::compress(Compression compression, std::span<const std::byte> bytes, wire::Bytes& to) {
  const size_t at = to.size();
  size_t packed = 0;
  bool good = false;
  if (compression == Compression::zstd) {
    if (!impl_->pack) impl_->pack = ZSTD_createCCtx();
    to.resize(at + ZSTD_compressBound(bytes.size()));
    if (impl_->pack)
      packed = ZSTD_compressCCtx(impl_->pack, to.data() + at, to.size() - at, bytes.data(), bytes.size(),
                                 kZstdLevel);
    good = impl_->pack && !ZSTD_isError(packed);
  } else if (compression == Compression::lz4) {
    LZ4F_preferences_t preferences{};
    preferences.frameInfo.contentSize = bytes.size();
    to.resize(at + LZ4F_compressFrameBound(bytes.size(), &preferences));
    packed = LZ4F_compressFrame(to.data() + at, to.size() - at, bytes.data(), bytes.size(), &preferences);
    good = !LZ4F_isError(packed);
  }
  good = good && packed < bytes.size();
  to.resize(at + (good ? packed : 0));
  return good;
}

Result<void> Compressor::decompress(Compression compression, std::span<const std::byte> packed,
                                    std::span<std::byte> to) {
  if (compression == Compression::none) {
    if (packed.size() != to.size()) return Error{"its length is not the one that it states"};
    std::memcpy(to.data(), packed.data(), packed.size());
    return {};
  }
  if (compression == Compression::zstd) {
    if (!impl_->unpack) impl_->unpack = ZSTD_createDCtx();
    if (!impl_->unpack) return Error{"there is no memory to unpack it"};
    const size_t got = ZSTD_decompressDCtx(impl_->unpack, to.data(), to.size(), packed.data(), packed.size());
    if (ZSTD_isError(got)) return Error{std::string("zstd cannot unpack it: ") + ZSTD_getErrorName(got)};
    if (got != to.size()) return Error{"it unpacks to another length than it states"};
    return {};
  }
  if (!impl_->unpack_lz4 && LZ4F_isError(LZ4F_createDecompressionContext(&impl_->unpack_lz4, LZ4F_VERSION)))
    return Error{"there is no memory to unpack it"};
  LZ4F_resetDecompressionContext(impl_->unpack_lz4);
  size_t read = 0, written = 0, hint = 1;
  while (hint != 0) {
    size_t in = packed.size() - read, out = to.size() - written;
    hint = LZ4F_decompress(impl_->unpack_lz4, to.data() + written, &out, packed.data() + read, &in, nullptr);
    if (LZ4F_isError(hint)) return Error{std::string("lz4 cannot unpack it: ") + LZ4F_getErrorName(hint)};
    read += in;
    written += out;
    if (in == 0 && out == 0 && hint != 0)
      return Error{"it unpacks to another length than it states, or is cut"};
  }
  if (written != to.size() || read != packed.size())
    return Error{"it unpacks to another length than it states"};
  return {};
}

}  // namespace fire3dv::record
