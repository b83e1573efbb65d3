// Container of KTX 2.0 files: the largest image of a two-dimensional texture and its description.
// Specification: https://registry.khronos.org/KTX/specs/2.0/ktxspec.v2.html
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/error.h"

namespace fire3dv::scene::ktx2 {

enum class Coding { etc1s, uastc, rgb8, rgba8 };
enum class Supercompression : uint32_t { none = 0, basis_lz = 1, zstandard = 2 };

// Source of a channel of the decoded image.
enum class Channel : uint8_t { red, green, blue, alpha, zero, one };

struct Ktx2File {
  uint32_t width = 0, height = 0;  // at least 1
  uint32_t level_count = 1;
  Coding coding = Coding::rgba8;
  Supercompression supercompression = Supercompression::none;
  std::optional<bool> is_srgb;  // transfer function: sRGB or linear; nullopt: another one, or unspecified
  // Channels of the texture from those of the coding, for codings of one, two or three channels, and then by
  // KTXswizzle.
  std::array<Channel, 4> swizzle{Channel::red, Channel::green, Channel::blue, Channel::alpha};
  bool has_alpha_slice = false;  // ETC1S: a second slice of blocks for the alpha channel
  bool is_premultiplied = false;
  bool is_mirrored_x = false, is_mirrored_y = false;  // KTXorientation: to the left, upwards
  std::span<const std::byte> level;                   // level 0, supercompressed
  std::span<const std::byte> global_data;             // of BasisLZ
};

// True if the bytes begin as a KTX 2.0 file.
bool is_ktx2(std::span<const std::byte> bytes);

// Reads the header and the descriptions, and checks that all of them are inside of the file. The result
// refers to the bytes. Errors are sentences about "it".
Result<Ktx2File> read_ktx2(std::span<const std::byte> bytes);

}  // namespace fire3dv::scene::ktx2
