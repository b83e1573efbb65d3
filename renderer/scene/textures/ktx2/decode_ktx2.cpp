#include "renderer/scene/textures/ktx2/decode_ktx2.h"

#include <zstd.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "renderer/scene/textures/ktx2/basis_lz.h"
#include "renderer/scene/textures/ktx2/uastc.h"

namespace fire3dv::scene::ktx2 {
namespace {

constexpr uint32_t kBlockSide = 4;
constexpr size_t kUastcBlockBytes = 16;

uint32_t blocks_of(uint32_t side) {
  return side / kBlockSide + (side % kBlockSide == 0 ? 0 : 1);
}

// Image under construction, with the file's channels and orientation.
class Target {
 public:
  explicit Target(const Ktx2File& file) : file_(file), rgba8_(size_t{4} * file.width * file.height) {}

  void put(uint32_t x, uint32_t y, const Rgba8& texel) {
    if (x >= file_.width || y >= file_.height) return;  // blocks overhang
    const uint32_t column = file_.is_mirrored_x ? file_.width - 1 - x : x;
    const uint32_t row = file_.is_mirrored_y ? file_.height - 1 - y : y;
    uint8_t* const to = rgba8_.data() + 4 * (size_t{row} * file_.width + column);
    for (size_t c = 0; c < 4; ++c) {
      const Channel source = file_.swizzle[c];
      to[c] = source == Channel::zero  ? uint8_t{0}
              : source == Channel::one ? uint8_t{255}
                                       : texel[static_cast<size_t>(source)];
    }
  }
  void put_block(uint32_t column, uint32_t row, const BlockTexels& texels) {
    for (uint32_t i = 0; i < 16; ++i)
      put(kBlockSide * column + i % kBlockSide, kBlockSide * row + i / kBlockSide, texels[i]);
  }
  std::vector<uint8_t> take() { return std::move(rgba8_); }

 private:
  const Ktx2File& file_;
  std::vector<uint8_t> rgba8_;
};

// Colour of a texel of an ETC1S block, by its selector 0 .. 3.
std::array<uint8_t, 3> etc1s_color(const Etc1sEndpoint& endpoint, uint32_t selector) {
  // ETC1's intensity modifiers.
  constexpr std::array<std::array<int, 2>, 8> kModifiers{
      {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}}};
  const std::array<int, 2>& modifiers = kModifiers[endpoint.intensity];
  const std::array<int, 4> by_selector{-modifiers[1], -modifiers[0], modifiers[0], modifiers[1]};
  std::array<uint8_t, 3> color{};
  for (size_t c = 0; c < 3; ++c) {
    const int base = endpoint.color5[c] << 3 | endpoint.color5[c] >> 2;
    color[c] = static_cast<uint8_t>(std::clamp(base + by_selector[selector], 0, 255));
  }
  return color;
}

uint32_t selector_at(const Etc1sSelector& selector, uint32_t texel) {
  return selector.rows[texel / kBlockSide] >> (2 * (texel % kBlockSide)) & 3u;
}

Result<std::vector<uint8_t>> decode_etc1s(const Ktx2File& file) {
  const uint32_t columns = blocks_of(file.width), rows = blocks_of(file.height);
  const Result<Etc1sImage> image =
      decode_basis_lz(file.global_data, file.level, columns, rows, file.level_count, file.has_alpha_slice);
  if (!image) return image.error();
  Target target(file);
  for (uint32_t row = 0; row < rows; ++row) {
    for (uint32_t column = 0; column < columns; ++column) {
      const size_t index = size_t{row} * columns + column;
      BlockTexels texels{};
      for (uint32_t i = 0; i < 16; ++i) {
        const Etc1sBlock& block = image->color[index];
        const std::array<uint8_t, 3> color = etc1s_color(block.endpoint, selector_at(block.selector, i));
        texels[i] = {color[0], color[1], color[2], 255};
        if (!file.has_alpha_slice) continue;
        const Etc1sBlock& alpha = image->alpha[index];
        texels[i][3] = etc1s_color(alpha.endpoint, selector_at(alpha.selector, i))[1];
      }
      target.put_block(column, row, texels);
    }
  }
  return target.take();
}

Result<std::vector<uint8_t>> decode_uastc_image(const Ktx2File& file, std::span<const std::byte> blocks) {
  Target target(file);
  const uint32_t columns = blocks_of(file.width), rows = blocks_of(file.height);
  for (uint32_t row = 0; row < rows; ++row) {
    for (uint32_t column = 0; column < columns; ++column) {
      const size_t index = size_t{row} * columns + column;
      const auto block = blocks.subspan(kUastcBlockBytes * index).first<kUastcBlockBytes>();
      target.put_block(column, row, decode_uastc(block, file.is_srgb.value_or(false)));
    }
  }
  return target.take();
}

Result<std::vector<uint8_t>> copy_texels(const Ktx2File& file, std::span<const std::byte> texels) {
  Target target(file);
  const size_t channels = file.coding == Coding::rgba8 ? 4 : 3;
  const std::byte* from = texels.data();
  for (uint32_t y = 0; y < file.height; ++y) {
    for (uint32_t x = 0; x < file.width; ++x, from += channels) {
      Rgba8 texel{0, 0, 0, 255};
      for (size_t c = 0; c < channels; ++c) texel[c] = static_cast<uint8_t>(from[c]);
      target.put(x, y, texel);
    }
  }
  return target.take();
}

uint64_t level_bytes(const Ktx2File& file) {
  if (file.coding == Coding::uastc)
    return uint64_t{kUastcBlockBytes} * blocks_of(file.width) * blocks_of(file.height);
  return uint64_t{file.coding == Coding::rgba8 ? 4u : 3u} * file.width * file.height;
}

// Level 0 without Zstandard. storage: of the result.
Result<std::span<const std::byte>> inflated(const Ktx2File& file, std::unique_ptr<std::byte[]>& storage) {
  const uint64_t size = level_bytes(file);
  if (file.supercompression == Supercompression::none) {
    if (file.level.size() >= size) return file.level.first(size);
    return Error{"its level 0 has " + std::to_string(file.level.size()) + " bytes, but needs " +
                 std::to_string(size)};
  }
  // A block of Zstandard has at most 128 KiB in 3 bytes or more: a small file must not claim gigabytes.
  constexpr uint64_t kMaxRatio = (uint64_t{128} << 10) / 3;
  if (size / kMaxRatio > file.level.size()) return Error{"its Zstandard data is cut short"};
  storage = std::make_unique_for_overwrite<std::byte[]>(size);
  const size_t got = ZSTD_decompress(storage.get(), size, file.level.data(), file.level.size());
  if (ZSTD_isError(got) != 0)
    return Error{std::string("its Zstandard data is damaged: ") + ZSTD_getErrorName(got)};
  if (got != size) {
    return Error{"its Zstandard data holds " + std::to_string(got) + " bytes, but level 0 needs " +
                 std::to_string(size)};
  }
  return std::span<const std::byte>(storage.get(), size);
}

}  // namespace

Result<std::vector<uint8_t>> decode_ktx2(const Ktx2File& file) {
  if (file.coding == Coding::etc1s) return decode_etc1s(file);
  std::unique_ptr<std::byte[]> storage;
  const Result<std::span<const std::byte>> level = inflated(file, storage);
  if (!level) return level.error();
  return file.coding == Coding::uastc ? decode_uastc_image(file, *level) : copy_texels(file, *level);
}

}  // namespace fire3dv::scene::ktx2
