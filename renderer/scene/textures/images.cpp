#include "renderer/scene/textures/images.h"

#include <algorithm>
#include <climits>
#include <memory>
#include <new>
#include <optional>

#include "protocol/base/parallel.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#include <stb/stb_image.h>

namespace fire3dv::scene {
namespace {

// Limit per file, 8 GiB decoded: small images may share bytes and compress well.
constexpr uint64_t kMaxPixelsInAll = uint64_t{1} << 31;

// Reads the image header only.
Result<uint64_t> count_pixels(const EncodedImage& encoded, uint64_t max_pixels) {
  if (encoded.bytes.size() > INT_MAX) return Error{encoded.where + " is larger than 2 GiB"};
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(reinterpret_cast<const stbi_uc*>(encoded.bytes.data()),
                             static_cast<int>(encoded.bytes.size()), &width, &height, &channels) ||
      width <= 0 || height <= 0) {
    return Error{encoded.where + " is neither a PNG nor a JPEG that can be read"};
  }
  const uint64_t pixels = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  if (pixels > max_pixels) {
    return Error{encoded.where + " is " + std::to_string(width) + " x " + std::to_string(height) +
                 " pixels large; at most " + std::to_string(max_pixels) + " pixels are read"};
  }
  return pixels;
}

Result<void> check_sizes(std::span<const EncodedImage> encoded, const ImageLimits& limits) {
  uint64_t pixels_in_all = 0;
  for (const EncodedImage& image : encoded) {
    const Result<uint64_t> pixels = count_pixels(image, limits.max_pixels);
    if (!pixels) return pixels.error();
    pixels_in_all += *pixels;
    if (pixels_in_all > kMaxPixelsInAll) {
      return Error{image.where + ": the file's images have more than " + std::to_string(kMaxPixelsInAll) +
                   " pixels in all; make them smaller or split the file"};
    }
  }
  if (!limits.reserve || pixels_in_all == 0) return {};
  if (Result<void> reserved = limits.reserve(4 * pixels_in_all); !reserved)
    return Error{"the images have " + std::to_string(pixels_in_all) + " pixels: " + reserved.error().message};
  return {};
}

Result<Image> decode(const EncodedImage& encoded) {
  const auto* data = reinterpret_cast<const stbi_uc*>(encoded.bytes.data());
  const int size = static_cast<int>(encoded.bytes.size());
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> rgba(
      stbi_load_from_memory(data, size, &width, &height, &channels, STBI_rgb_alpha), stbi_image_free);
  if (!rgba) return Error{encoded.where + " cannot be decoded: " + stbi_failure_reason()};
  Image image;
  image.name = encoded.name;
  image.width = static_cast<uint32_t>(width);
  image.height = static_cast<uint32_t>(height);
  image.rgba8.edit().assign(rgba.get(), rgba.get() + static_cast<size_t>(image.width) * image.height * 4);
  return image;
}

Result<Image> decode_or_out_of_memory(const EncodedImage& encoded, const ImageLimits& limits) {
  if (limits.stop_requested && limits.stop_requested())
    return Error{encoded.where + " is not decoded: the load was stopped"};
  try {
    return decode(encoded);
  } catch (const std::bad_alloc&) {
    return Error{encoded.where + " does not fit into memory"};
  }
}

}  // namespace

Result<std::vector<Image>> decode_images(std::span<const EncodedImage> encoded, const ImageLimits& limits,
                                         const std::function<void(size_t done)>& progress) {
  if (Result<void> sizes = check_sizes(encoded, limits); !sizes) return sizes.error();
  std::vector<std::optional<Result<Image>>> results(encoded.size());
  parallel_for(
      encoded.size(), [&](size_t i) { results[i].emplace(decode_or_out_of_memory(encoded[i], limits)); },
      progress);
  if (progress && !encoded.empty()) progress(encoded.size());

  std::vector<Image> images;
  images.reserve(encoded.size());
  for (auto& result : results) {
    if (!result->ok()) return result->error();
    images.push_back(std::move(**result));
  }
  return images;
}

}  // namespace fire3dv::scene
