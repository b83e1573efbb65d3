#include "renderer/scene/textures/images.h"

#include <new>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "renderer/scene/textures/image_codecs.h"

namespace fire3dv::scene {
namespace {

// Limit per file, 8 GiB decoded: small images may share bytes and compress well.
constexpr uint64_t kMaxPixelsInAll = uint64_t{1} << 31;

Result<ImageHeader> readable_header(const EncodedImage& encoded, uint64_t max_pixels) {
  if (!encoded.read_error.empty()) return Error{encoded.read_error};
  Result<ImageHeader> header = read_image_header(encoded.bytes);
  if (!header || header->pixels() <= max_pixels) return header;
  return Error{"it is " + std::to_string(header->width) + " x " + std::to_string(header->height) +
               " pixels large; at most " + std::to_string(max_pixels) + " pixels are read"};
}

Result<void> check_sizes(std::span<const EncodedImage> encoded, std::span<const Result<ImageHeader>> headers,
                         const ImageLimits& limits) {
  uint64_t pixels_in_all = 0;
  for (size_t i = 0; i < headers.size(); ++i) {
    if (!headers[i]) continue;
    pixels_in_all += headers[i]->pixels();
    if (pixels_in_all > kMaxPixelsInAll) {
      return Error{encoded[i].where + ": the file's images have more than " +
                   std::to_string(kMaxPixelsInAll) + " pixels in all; make them smaller or split the file"};
    }
  }
  if (!limits.reserve || pixels_in_all == 0) return {};
  if (Result<void> reserved = limits.reserve(4 * pixels_in_all); !reserved)
    return Error{"the images have " + std::to_string(pixels_in_all) + " pixels: " + reserved.error().message};
  return {};
}

struct Outcome {
  std::optional<Image> image;
  std::string fault;        // of the image: it becomes a placeholder
  std::string fatal_error;  // of the load
};

Outcome decode(const EncodedImage& encoded, const Result<ImageHeader>& header, const ImageLimits& limits) {
  Outcome outcome;
  if (limits.stop_requested && limits.stop_requested()) {
    outcome.fatal_error = encoded.where + " is not decoded: the load was stopped";
    return outcome;
  }
  if (!header) {
    outcome.fault = header.error().message;
    return outcome;
  }
  try {
    Result<Image> image = decode_image(*header, encoded.bytes);
    if (image) {
      outcome.image = std::move(*image);
      outcome.image->name = encoded.name;
    } else {
      outcome.fault = image.error().message;
    }
  } catch (const std::bad_alloc&) {
    outcome.fatal_error = encoded.where + " does not fit into memory";
  }
  return outcome;
}

std::string placeholder_warning(const EncodedImage& encoded, const std::string& fault) {
  std::string warning = encoded.where + ": " + fault;
  if (encoded.is_color) warning += "; a magenta checker is shown instead";
  if (encoded.is_data) warning += encoded.is_color ? ", and other uses are left out" : "; it is left out";
  return warning;
}

// Colour and data textures differ in how their values are read; the use decides.
void add_warnings(const EncodedImage& encoded, const ImageHeader& header,
                  std::vector<std::string>& warnings) {
  for (const std::string& note : header.notes) warnings.push_back(encoded.where + ": " + note);
  if (!header.is_srgb) return;
  if (*header.is_srgb && encoded.is_data)
    warnings.push_back(encoded.where + ": its transfer function is sRGB, but a material uses it as data");
  if (!*header.is_srgb && encoded.is_color) {
    warnings.push_back(encoded.where +
                       ": its transfer function is linear, but a material uses it as sRGB colours");
  }
}

}  // namespace

Image placeholder_image(const std::string& name) {
  constexpr uint32_t kSide = 64, kSquare = 8;
  Image image;
  image.name = name;
  image.width = image.height = kSide;
  std::vector<uint8_t>& rgba8 = image.rgba8.edit();
  rgba8.reserve(size_t{4} * kSide * kSide);
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const uint8_t magenta = (x / kSquare + y / kSquare) % 2 == 0 ? 255 : 0;
      rgba8.insert(rgba8.end(), {magenta, 0, magenta, 255});
    }
  }
  return image;
}

Result<DecodedImages> decode_images(std::span<const EncodedImage> encoded, const ImageLimits& limits,
                                    const std::function<void(size_t done)>& progress) {
  std::vector<Result<ImageHeader>> headers;
  for (const EncodedImage& image : encoded) headers.push_back(readable_header(image, limits.max_pixels));
  if (Result<void> sizes = check_sizes(encoded, headers, limits); !sizes) return sizes.error();
  std::vector<Outcome> outcomes(encoded.size());
  parallel_for(
      encoded.size(), [&](size_t i) { outcomes[i] = decode(encoded[i], headers[i], limits); }, progress);
  if (progress && !encoded.empty()) progress(encoded.size());

  DecodedImages decoded;
  for (size_t i = 0; i < outcomes.size(); ++i) {
    Outcome& outcome = outcomes[i];
    if (!outcome.fatal_error.empty()) return Error{outcome.fatal_error};
    decoded.is_placeholder.push_back(!outcome.image.has_value());
    if (outcome.image) {
      decoded.images.push_back(std::move(*outcome.image));
      add_warnings(encoded[i], *headers[i], decoded.warnings);
    } else {
      decoded.images.push_back(placeholder_image(encoded[i].name));
      decoded.warnings.push_back(placeholder_warning(encoded[i], outcome.fault));
    }
  }
  return decoded;
}

}  // namespace fire3dv::scene
