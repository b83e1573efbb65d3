// Writer of a Model as one self-contained binary glTF 2.0 file (GLB), and its images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "convert/model.h"

namespace fire3dv::convert {

// Skips empty surfaces and meshes, and unused elements. Equal models give equal bytes. warnings: receives a
// message per undecodable image and per repaired surface; may be null.
Result<std::vector<std::byte>> write_glb(const Model& model, std::vector<std::string>* warnings = nullptr);

// glTF image encoding: PNG and JPEG files unchanged, other decodable formats as PNG.
struct GlbImage {
  std::string mime_type;
  std::vector<std::byte> made;       // PNG of a re-encoded image
  std::span<const std::byte> bytes;  // the source's bytes, or `made`
};

constexpr uint64_t kMaxPixelsInAll = uint64_t{1} << 31;  // limit per file, as in the renderer's loader

// The result may borrow the image's bytes. The image is decodable, except that JPEG files of the usual kinds
// may have damaged pixels, since only their structure is checked. Its pixels are subtracted from pixels_left.
// The error has the reason without the image's name.
Result<GlbImage> glb_image(const Image& image, uint64_t& pixels_left);

// Packs two grey images as glTF does: G roughness, B metalness. An empty one stands for white. The size is
// that of the larger image. The error has the reason without a name.
Result<std::vector<std::byte>> metallic_roughness_png(std::span<const std::byte> roughness,
                                                      std::span<const std::byte> metallic);

// Image with the colours of one image and the opacity of another.
struct OpacityPng {
  std::vector<std::byte> png;
  bool is_opaque = false;  // all of it
  bool is_cutout = false;  // nearly all of it is either opaque or invisible
};

// color: white where empty. own: color and opacity are one image; without any opacity of its own the result
// is opaque, unless a channel is named. The size is that of the larger image. The error has the reason
// without a name.
Result<OpacityPng> opacity_png(std::span<const std::byte> color, std::span<const std::byte> opacity,
                               OpacityChannel channel, bool own);

// Encodes 8 bits per channel, rows from the top, 3 or 4 channels. Equal pixels give equal bytes.
Result<std::vector<std::byte>> png_of(std::span<const uint8_t> pixels, uint32_t width, uint32_t height,
                                      uint32_t channels);

}  // namespace fire3dv::convert
