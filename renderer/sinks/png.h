// PNG codec with provenance metadata. Each image that FIRE-3DV writes has these text chunks:
//
//   Software     "FIRE-3DV", version of the renderer
//   Camera       camera name; absent if the image has none
//   Frame        index of the image in its run of the renderer, from 0
//   Provenance   JSON: inputs, options, build and machine of the run (run_provenance.h); at most 64 KiB
//   Renderer     "path" for path-traced images, with SamplesPerPixel, Bounces and Seed; absent for raster
//   Streams      number of streams in the image; 0 = the scene at rest
//   Stream       adapter name
//   Epoch        16 hexadecimal digits: the run of the stream
//   Sequence     sequence number of the pose frame, from 1
//   SimTimeNs    simulator time in nanoseconds
//   PublishTimeNs  publish time on the publisher's monotonic clock, in nanoseconds
//
// The last five occur once per stream; several streams have numbered keywords: "Stream.0", "Stream.1" ...
// ASCII text is stored in tEXt chunks, other text in iTXt chunks (UTF-8). Pixels are tagged as sRGB.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

using TextChunks = std::vector<std::pair<std::string, std::string>>;  // keyword, UTF-8 text

struct PngFile {
  FrameImage image;  // frame_index, camera and shown come from the text chunks
  TextChunks text;
  bool srgb = false;
};

struct PngLimits {
  uint32_t max_side = 32768;
  uint64_t max_pixels = uint64_t{1} << 28;
};

// Encodes deterministically. Opaque images are stored without alpha channel.
Result<std::vector<uint8_t>> encode_png(const FrameImage& image);

// Decodes untrusted bytes. Every colour type is converted to 8-bit RGBA; unknown text chunks are returned as
// they are.
Result<PngFile> decode_png(std::span<const uint8_t> bytes, const PngLimits& limits = {});

// Errors name the path. Files are replaced atomically.
Result<void> write_png(const std::filesystem::path& path, const FrameImage& image,
                       base::Durability durability = base::Durability::contents_and_name);
Result<PngFile> read_png(const std::filesystem::path& path, const PngLimits& limits = {});

// Convert between provenance and the text chunks of the table above.
TextChunks text_of(const FrameImage& image);
void apply_text(const TextChunks& text, FrameImage& image);

std::string hex64(uint64_t value);  // 16 digits, the notation of epochs

}  // namespace fire3dv::sinks
