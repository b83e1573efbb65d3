#include "protocol/record/mcap/compress.h"

#include <lz4frame.h>
#include <zstd.h>

#include <cstring>
#include <string>

namespace fire3dv::record {
namespace {

// Higher levels hardly reduce the size of poses and take several times as long.
constexpr int kZstdLevel = 1;

}  // namespace

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
