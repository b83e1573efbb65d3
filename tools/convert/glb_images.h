// Images as glTF takes them: PNG and JPEG as they are, whatever else can be decoded as PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

struct GlbImage {
  std::string mime_type;
  std::vector<std::byte> made;       // where it had to be encoded anew
  std::span<const std::byte> bytes;  // the image's own, or `made`
};

constexpr uint64_t kMostPixelsInAll = uint64_t{1} << 31;  // of a file's images: what the renderer loads, too

// The result looks into the image's bytes. It is one that can be decoded, and its pixels are taken off those
// that are left. The error says why it cannot be shown, without its name.
Result<GlbImage> glb_image(const Image& image, uint64_t& pixels_left);

// 8 bits a channel, rows from the top; channels: 3 or 4. The same pixels give the same bytes.
Result<std::vector<std::byte>> png_of(std::span<const uint8_t> pixels, uint32_t width, uint32_t height,
                                      uint32_t channels);

}  // namespace fire3dv::convert
