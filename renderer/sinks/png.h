// PNG files that say what they show. Text chunks of every image that FIRE-3DV writes:
//
//   Software     "FIRE-3DV 0.1.0"
//   Camera       name of the camera; absent when the image has none
//   Frame        index of the image in its run of the renderer, from 0
//   Streams      how many streams the image shows; 0 = the scene at rest
//   Stream       the adapter's name
//   Epoch        16 hexadecimal digits: the run of the stream
//   Sequence     which pose frame, from 1
//   SimTimeNs    the simulator's time, nanoseconds
//   PublishTimeNs  when it was published, by the publisher's monotonic clock, nanoseconds
//
// The last five stand once for each stream; when there are several, with a number: "Stream.0", "Stream.1" ...
// Names that are plain ASCII are tEXt chunks, others iTXt in UTF-8. The pixels are marked as sRGB.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/atomic_file.h"
#include "protocol/error.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

using TextChunks = std::vector<std::pair<std::string, std::string>>;  // keyword, UTF-8 text

struct PngFile {
  FrameImage image;  // with frame_index, camera and shown as the text chunks have them
  TextChunks text;
  bool srgb = false;
};

struct PngLimits {
  uint32_t max_side = 32768;
  uint64_t max_pixels = uint64_t{1} << 28;
};

// Opaque images are stored without an alpha channel. The same image gives the same bytes.
Result<std::vector<uint8_t>> encode_png(const FrameImage& image);

// Bytes may come from anywhere. Every PNG colour type becomes RGBA with 8 bits; text that is not ours is kept
// as it is.
Result<PngFile> decode_png(std::span<const uint8_t> bytes, const PngLimits& limits = {});

// The errors of these two name the path. Files are replaced atomically.
Result<void> write_png(const std::filesystem::path& path, const FrameImage& image,
                       base::Durability durability = base::Durability::contents_and_name);
Result<PngFile> read_png(const std::filesystem::path& path, const PngLimits& limits = {});

// The text chunks as the table above says, and back.
TextChunks text_of(const FrameImage& image);
void apply_text(const TextChunks& text, FrameImage& image);

std::string hex64(uint64_t value);  // 16 digits, as epochs are written

}  // namespace fire3dv::sinks
