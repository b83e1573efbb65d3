#include "convert/glb/write_glb.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <climits>
#include <cstring>
#include <memory>
#include <optional>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#include <stb/stb_image.h>

#include "convert/glb/jpeg_check.h"

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMaxPixels = 16384ull * 16384ull;  // limit of the renderer's loader

uint32_t big_endian(const std::byte* bytes) {
  uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | std::to_integer<uint32_t>(bytes[i]);
  return value;
}

bool begins_with(std::span<const std::byte> bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

bool is_png(std::span<const std::byte> bytes) {
  return begins_with(bytes, "\x89PNG\r\n\x1a\n");
}

// Detects truncated files, which would make the loader refuse the whole scene.
bool png_is_whole(std::span<const std::byte> bytes) {
  size_t at = 8;
  while (bytes.size() - at >= 12) {
    const uint64_t length = big_endian(&bytes[at]);
    if (length > bytes.size() - at - 12) return false;
    if (std::memcmp(&bytes[at + 4], "IEND", 4) == 0) return true;
    at += static_cast<size_t>(length) + 12;
  }
  return false;
}

// Inflates the pixels of a PNG without keeping them, and checks their size and filters: several times as fast
// as decoding them. Returns nothing where only decoding can tell (interlaced images, unknown chunks).
class PngCheck {
 public:
  static std::optional<bool> is_sound(std::span<const std::byte> bytes) { return PngCheck().check(bytes); }

 private:
  PngCheck() = default;
  PngCheck(const PngCheck&) = delete;
  PngCheck& operator=(const PngCheck&) = delete;
  ~PngCheck() { inflateEnd(&stream_); }

  std::optional<bool> check(std::span<const std::byte> bytes) {
    bool has_palette = false;
    for (size_t at = 8; bytes.size() - at >= 12;) {  // png_is_whole() has checked the lengths
      const size_t length = big_endian(&bytes[at]);
      const std::string_view type(reinterpret_cast<const char*>(&bytes[at + 4]), 4);
      const std::span<const std::byte> data = bytes.subspan(at + 8, length);
      at += length + 12;
      if (type == "IHDR") {
        if (row_bytes_ > 0 || !read_header(data)) return std::nullopt;
      } else if (type == "PLTE") {
        has_palette = length > 0 && length <= 768 && length % 3 == 0;
      } else if (type == "IDAT") {
        if (row_bytes_ == 0 || (needs_palette_ && !has_palette)) return std::nullopt;
        if (!inflate_part(data)) return false;
      } else if (type == "IEND") {
        break;
      } else if ((type[0] & 0x20) == 0 || type == "tRNS") {
        return std::nullopt;  // unknown critical chunk, or transparency, whose size depends on the kind
      }
    }
    return row_bytes_ > 0 && rows_ == height_ && column_ == 0;
  }

  bool read_header(std::span<const std::byte> data) {
    if (data.size() != 13) return false;
    const uint64_t width = big_endian(&data[0]);
    const auto depth = std::to_integer<unsigned>(data[8]), kind = std::to_integer<unsigned>(data[9]);
    constexpr uint64_t kChannels[] = {1, 0, 3, 1, 2, 0, 4};
    const bool is_plain = data[10] == std::byte{0} && data[11] == std::byte{0} && data[12] == std::byte{0};
    if (kind > 6 || kChannels[kind] == 0 || !is_plain) return false;
    if (depth != 8 && (depth != 16 || kind == 3)) return false;
    height_ = big_endian(&data[4]);
    row_bytes_ = 1 + width * kChannels[kind] * depth / 8;
    needs_palette_ = kind == 3;
    return width > 0 && height_ > 0 && inflateInit(&stream_) == Z_OK;
  }

  bool inflate_part(std::span<const std::byte> data) {
    stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(data.data()));
    stream_.avail_in = static_cast<uInt>(data.size());
    while (stream_.avail_in > 0 && !ended_) {
      stream_.next_out = buffer_.data();
      stream_.avail_out = static_cast<uInt>(buffer_.size());
      const int result = inflate(&stream_, Z_NO_FLUSH);
      if (result != Z_OK && result != Z_STREAM_END) return false;
      ended_ = result == Z_STREAM_END;
      if (!take(buffer_.size() - stream_.avail_out)) return false;
    }
    return true;
  }

  // Each row begins with its filter, 0 to 4.
  bool take(size_t count) {
    for (size_t at = 0; at < count;) {
      if (rows_ == height_) return false;
      if (column_ == 0 && buffer_[at] > 4) return false;
      const size_t part = std::min<size_t>(count - at, row_bytes_ - column_);
      at += part;
      column_ += part;
      if (column_ == row_bytes_) {
        column_ = 0;
        ++rows_;
      }
    }
    return true;
  }

  z_stream stream_{};
  std::vector<Bytef> buffer_ = std::vector<Bytef>(size_t{1} << 18);
  uint64_t row_bytes_ = 0, height_ = 0, rows_ = 0, column_ = 0;
  bool needs_palette_ = false, ended_ = false;
};

bool jpeg_is_whole(std::span<const std::byte> bytes) {
  constexpr size_t kMaxTrailing = 65536;  // cameras append data behind the image
  const size_t first = bytes.size() > kMaxTrailing ? bytes.size() - kMaxTrailing : 0;
  for (size_t i = bytes.size(); i-- > first + 1;) {
    if (bytes[i] == std::byte{0xd9} && bytes[i - 1] == std::byte{0xff}) return true;
  }
  return false;
}

}  // namespace

Result<std::vector<std::byte>> png_of(std::span<const uint8_t> pixels, uint32_t width, uint32_t height,
                                      uint32_t channels) {
  FIRE3DV_ASSERT(pixels.size() == size_t{width} * height * channels && (channels == 3 || channels == 4));
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = width;
  header.height = height;
  header.flags = PNG_IMAGE_FLAG_FAST;
  header.format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(header));
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, pixels.data(), 0, nullptr)) {
    return Error{std::string("it cannot be encoded as PNG: ") + header.message};
  }
  bytes.resize(size);
  return bytes;
}

namespace {

// Image of 8 bits for each channel; one pixel until it is decoded.
struct DecodedImage {
  std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels{nullptr, &stbi_image_free};
  size_t width = 1, height = 1;
  size_t channels = 1;

  // The nearest pixel for that of an image of the size.
  const stbi_uc* at(size_t x, size_t y, size_t of_width, size_t of_height) const {
    return pixels.get() + (y * height / of_height * width + x * width / of_width) * channels;
  }
};

// The error is about "one" of several images.
Result<DecodedImage> decoded_image(std::span<const std::byte> bytes, int wanted_channels) {
  if (bytes.size() > INT_MAX) return Error{"one is larger than 2 GiB"};
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(data, static_cast<int>(bytes.size()), &width, &height, &channels) ||
      width <= 0 || height <= 0)
    return Error{"one is not an image of a kind that can be decoded"};
  if (static_cast<uint64_t>(width) * static_cast<uint64_t>(height) > kMaxPixels / 4)
    return Error{"one has too many pixels; make it smaller"};
  DecodedImage made;
  made.pixels.reset(stbi_load_from_memory(data, static_cast<int>(bytes.size()), &width, &height, &channels,
                                          wanted_channels));
  if (!made.pixels) return Error{std::string("one cannot be decoded: ") + stbi_failure_reason()};
  made.width = static_cast<size_t>(width);
  made.height = static_cast<size_t>(height);
  made.channels = static_cast<size_t>(wanted_channels);
  return made;
}

Error too_large_together() {
  return Error{"together they have too many pixels; make them smaller"};
}

}  // namespace

Result<std::vector<std::byte>> metallic_roughness_png(std::span<const std::byte> roughness,
                                                      std::span<const std::byte> metallic) {
  DecodedImage images[2];
  for (size_t i = 0; i < 2; ++i) {
    const std::span<const std::byte> bytes = i == 0 ? roughness : metallic;
    if (bytes.empty()) continue;
    Result<DecodedImage> decoded = decoded_image(bytes, 1);
    if (!decoded) return decoded.error();
    images[i] = std::move(*decoded);
  }
  const size_t width = std::max(images[0].width, images[1].width);
  const size_t height = std::max(images[0].height, images[1].height);
  if (width * height > kMaxPixels / 4) return too_large_together();
  std::vector<uint8_t> packed(width * height * 3, 255);
  for (size_t y = 0; y < height; ++y)
    for (size_t x = 0; x < width; ++x)
      for (size_t i = 0; i < 2; ++i)
        if (images[i].pixels) packed[(y * width + x) * 3 + 1 + i] = *images[i].at(x, y, width, height);
  return png_of(packed, static_cast<uint32_t>(width), static_cast<uint32_t>(height), 3);
}

Result<OpacityPng> opacity_png(std::span<const std::byte> color, std::span<const std::byte> opacity,
                               OpacityChannel channel, bool own) {
  DecodedImage base;
  if (!color.empty()) {
    Result<DecodedImage> decoded = decoded_image(color, 4);
    if (!decoded) return decoded.error();
    base = std::move(*decoded);
  }
  Result<DecodedImage> mask = decoded_image(opacity, 4);
  if (!mask) return mask.error();
  const stbi_uc* const first = mask->pixels.get();
  if (channel == OpacityChannel::automatic) {
    channel = OpacityChannel::brightness;
    for (size_t i = 0; i < mask->width * mask->height && channel == OpacityChannel::brightness; ++i)
      if (first[4 * i + 3] != 255) channel = OpacityChannel::opacity;
    if (own) channel = OpacityChannel::opacity;
  }
  const size_t width = std::max(base.width, mask->width), height = std::max(base.height, mask->height);
  if (width * height > kMaxPixels / 4) return too_large_together();
  std::vector<uint8_t> made(width * height * 4, 255);
  size_t opaque = 0, between = 0;
  for (size_t y = 0; y < height; ++y) {
    for (size_t x = 0; x < width; ++x) {
      uint8_t* const to = &made[(y * width + x) * 4];
      if (base.pixels) std::memcpy(to, base.at(x, y, width, height), 3);
      const stbi_uc* const from = mask->at(x, y, width, height);
      constexpr size_t kRed = static_cast<size_t>(OpacityChannel::red);
      to[3] = channel == OpacityChannel::opacity ? from[3]
              : channel == OpacityChannel::brightness
                  ? (77 * from[0] + 150 * from[1] + 29 * from[2] + 128) / 256
                  : from[static_cast<size_t>(channel) - kRed];
      opaque += to[3] == 255 ? 1 : 0;
      between += to[3] > 25 && to[3] < 230 ? 1 : 0;
    }
  }
  Result<std::vector<std::byte>> png =
      png_of(made, static_cast<uint32_t>(width), static_cast<uint32_t>(height), 4);
  if (!png) return png.error();
  // Edges of leaves and grids have a few values between.
  constexpr size_t kFew = 10;  // one in as many
  return OpacityPng{std::move(*png), opaque == width * height, between * kFew <= width * height};
}

Result<GlbImage> glb_image(const Image& image, uint64_t& pixels_left) {
  const std::span<const std::byte> bytes = image.bytes;
  if (bytes.size() > INT_MAX) return Error{"it is larger than 2 GiB"};
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(data, size, &width, &height, &channels) || width <= 0 || height <= 0) {
    return Error{"it is not an image of a kind that can be decoded (PNG, JPEG, BMP, TGA, GIF, PSD, PNM)"};
  }
  const uint64_t pixels = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  if (pixels > kMaxPixels) {
    return Error{"it is " + std::to_string(width) + " x " + std::to_string(height) +
                 " pixels large; make it smaller"};
  }
  if (pixels > pixels_left) return Error{"all images together have too many pixels; make them smaller"};
  const bool png = is_png(bytes), jpeg = begins_with(bytes, "\xff\xd8\xff");
  if (png && !png_is_whole(bytes)) return Error{"the PNG file is cut short"};
  if (jpeg && !jpeg_is_whole(bytes)) return Error{"the JPEG file is cut short"};
  if (png && PngCheck::is_sound(bytes).value_or(false)) {
    pixels_left -= pixels;
    return GlbImage{"image/png", {}, bytes};
  }
  if (jpeg && is_sound_jpeg(bytes)) {
    pixels_left -= pixels;
    return GlbImage{"image/jpeg", {}, bytes};
  }
  // Decodes other images that are copied unchanged, too, with the renderer's decoder: an image that fails
  // there would fail the whole scene.
  const int wanted = png || jpeg || channels == 2 || channels == 4 ? 4 : 3;
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> decoded(
      stbi_load_from_memory(data, size, &width, &height, &channels, wanted), &stbi_image_free);
  if (!decoded) return Error{std::string("it cannot be decoded: ") + stbi_failure_reason()};
  pixels_left -= pixels;
  if (png || jpeg) return GlbImage{png ? "image/png" : "image/jpeg", {}, bytes};
  const auto w = static_cast<uint32_t>(width), h = static_cast<uint32_t>(height);
  const auto count = static_cast<uint32_t>(wanted);
  Result<std::vector<std::byte>> encoded = png_of({decoded.get(), size_t{w} * h * count}, w, h, count);
  if (!encoded) return encoded.error();
  GlbImage made{"image/png", std::move(*encoded), {}};
  made.bytes = made.made;
  return made;
}

}  // namespace fire3dv::convert
