#include "convert/mjcf/assets/png_pixels.h"

#include <cstring>
#include <string>
#include <string_view>

#include "renderer/scene/textures/image_codecs.h"

namespace fire3dv::convert {

bool is_png_file(std::span<const std::byte> bytes) {
  constexpr std::string_view kMagic = "\x89PNG\r\n\x1a\n";
  return bytes.size() >= kMagic.size() && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

Result<PngPixels> decode_png(std::span<const std::byte> bytes) {
  constexpr uint64_t kMaxPixels = uint64_t{1} << 26;
  const Error damaged{"the PNG file cannot be decoded"};
  const Result<scene::ImageHeader> header = scene::read_image_header(bytes);
  if (!header) return damaged;
  if (header->pixels() > kMaxPixels)
    return Error{"the PNG file has more than " + std::to_string(kMaxPixels) + " pixels; make it smaller"};
  const Result<scene::Image> image = scene::decode_image(*header, bytes);
  if (!image) return damaged;
  PngPixels pixels{image->width, image->height, {}};
  pixels.rgb.reserve(3 * header->pixels());
  for (size_t i = 0; i < 4 * header->pixels(); ++i)
    if (i % 4 != 3) pixels.rgb.push_back(image->rgba8[i]);
  return pixels;
}

}  // namespace fire3dv::convert
