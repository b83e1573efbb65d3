#include "tools/convert/glb/write_glb.h"

#include <png.h>

#include <climits>
#include <cstring>
#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#include <stb/stb_image.h>

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
  header.format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(header));
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, pixels.data(), 0, nullptr)) {
    return Error{std::string("it cannot be encoded as PNG: ") + header.message};
  }
  bytes.resize(size);
  return bytes;
}

Result<GlbImage> glb_image(const Image& image, uint64_t& pixels_left) {
  const std::span<const std::byte> bytes = image.bytes;
  if (bytes.size() > INT_MAX) return Error{"it is larger than 2 GiB"};
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(data, size, &width, &height, &channels) || width <= 0 || height <= 0) {
    return Error{"it is no image of a kind that can be decoded (PNG, JPEG, BMP, TGA, GIF, PSD, PNM)"};
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
  // Decodes even images that are copied unchanged, with the renderer's decoder: an image that fails there
  // would fail the whole scene.
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
