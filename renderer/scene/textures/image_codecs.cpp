#include "renderer/scene/textures/image_codecs.h"

#include <climits>
#include <cstring>
#include <memory>
#include <new>
#include <string_view>
#include <utility>

#include "renderer/scene/textures/ktx2/decode_ktx2.h"
#include "renderer/scene/textures/ktx2/ktx2_file.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#include <stb/stb_image.h>
#include <webp/decode.h>

namespace fire3dv::scene {
namespace {

bool begins_with(std::span<const std::byte> bytes, std::string_view signature) {
  return bytes.size() >= signature.size() &&
         std::memcmp(bytes.data(), signature.data(), signature.size()) == 0;
}

const stbi_uc* data_of(std::span<const std::byte> bytes) {
  return reinterpret_cast<const stbi_uc*>(bytes.data());
}

Result<ImageHeader> png_or_jpeg_header(std::span<const std::byte> bytes) {
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(data_of(bytes), static_cast<int>(bytes.size()), &width, &height, &channels) ||
      width <= 0 || height <= 0) {
    return Error{std::string("its header cannot be read: ") + stbi_failure_reason()};
  }
  return ImageHeader{
      ImageFormat::png_or_jpeg, static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}, {}};
}

Result<Image> decode_png_or_jpeg(const ImageHeader& header, std::span<const std::byte> bytes) {
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> rgba(
      stbi_load_from_memory(data_of(bytes), static_cast<int>(bytes.size()), &width, &height, &channels,
                            STBI_rgb_alpha),
      stbi_image_free);
  if (!rgba) {
    const std::string_view reason = stbi_failure_reason();
    if (reason == "outofmem") throw std::bad_alloc();
    return Error{"it cannot be decoded: " + std::string(reason)};
  }
  if (static_cast<uint32_t>(width) != header.width || static_cast<uint32_t>(height) != header.height)
    return Error{"its size differs from its header"};
  Image image;
  image.width = header.width;
  image.height = header.height;
  image.rgba8.edit().assign(rgba.get(), rgba.get() + 4 * header.pixels());
  return image;
}

bool is_webp(std::span<const std::byte> bytes) {
  return bytes.size() >= 12 && begins_with(bytes, "RIFF") && begins_with(bytes.subspan(8), "WEBP");
}

Result<ImageHeader> webp_header(std::span<const std::byte> bytes) {
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), &features) !=
          VP8_STATUS_OK ||
      features.width <= 0 || features.height <= 0)
    return Error{"its WebP header cannot be read"};
  if (features.has_animation != 0) return Error{"it is an animation; save one image of it"};
  return ImageHeader{ImageFormat::webp,
                     static_cast<uint32_t>(features.width),
                     static_cast<uint32_t>(features.height),
                     {},
                     {}};
}

Result<Image> decode_webp(const ImageHeader& header, std::span<const std::byte> bytes) {
  Image image;
  image.width = header.width;
  image.height = header.height;
  std::vector<uint8_t>& rgba8 = image.rgba8.edit();
  rgba8.resize(4 * header.pixels());
  WebPDecoderConfig config;
  if (WebPInitDecoderConfig(&config) == 0) return Error{"libwebp has another version than at the build"};
  config.output.colorspace = MODE_RGBA;
  config.output.is_external_memory = 1;
  config.output.u.RGBA = {rgba8.data(), static_cast<int>(4 * header.width), rgba8.size()};
  const VP8StatusCode status =
      WebPDecode(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), &config);
  // libwebp 1.5 also reports this for damaged files.
  if (status == VP8_STATUS_OUT_OF_MEMORY)
    return Error{"the WebP cannot be decoded: it is damaged, or memory is short"};
  if (status != VP8_STATUS_OK) {
    return Error{status == VP8_STATUS_NOT_ENOUGH_DATA ? "the WebP is cut short"
                                                      : "the WebP cannot be decoded: it is damaged"};
  }
  return image;
}

Result<ImageHeader> ktx2_header(std::span<const std::byte> bytes) {
  const Result<ktx2::Ktx2File> file = ktx2::read_ktx2(bytes);
  if (!file) return file.error();
  ImageHeader header{ImageFormat::ktx2, file->width, file->height, file->is_srgb, {}};
  if (file->is_mirrored_x || file->is_mirrored_y)
    header.notes.emplace_back(
        "its KTXorientation is not \"rd\", which glTF requires; it is mirrored to that");
  if (file->is_premultiplied)
    header.notes.emplace_back(
        "its colours are multiplied by alpha, which glTF does not allow; they are kept");
  return header;
}

Result<Image> decode_ktx2_image(std::span<const std::byte> bytes) {
  const Result<ktx2::Ktx2File> file = ktx2::read_ktx2(bytes);
  if (!file) return file.error();
  Result<std::vector<uint8_t>> rgba8 = ktx2::decode_ktx2(*file);
  if (!rgba8) return rgba8.error();
  Image image;
  image.width = file->width;
  image.height = file->height;
  image.rgba8 = std::move(*rgba8);
  return image;
}

}  // namespace

Result<ImageHeader> read_image_header(std::span<const std::byte> bytes) {
  if (bytes.size() > INT_MAX) return Error{"it is larger than 2 GiB"};
  if (begins_with(bytes, "\x89PNG\r\n\x1a\n") || begins_with(bytes, "\xff\xd8\xff"))
    return png_or_jpeg_header(bytes);
  if (is_webp(bytes)) return webp_header(bytes);
  if (ktx2::is_ktx2(bytes)) return ktx2_header(bytes);
  return Error{"it is none of PNG, JPEG, WebP and KTX 2.0"};
}

Result<Image> decode_image(const ImageHeader& header, std::span<const std::byte> bytes) {
  switch (header.format) {
    case ImageFormat::png_or_jpeg:
      return decode_png_or_jpeg(header, bytes);
    case ImageFormat::webp:
      return decode_webp(header, bytes);
    case ImageFormat::ktx2:
      return decode_ktx2_image(bytes);
  }
  return Error{"its format is unknown"};
}

}  // namespace fire3dv::scene
