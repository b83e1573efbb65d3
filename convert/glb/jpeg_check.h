// Structure check of JPEG files without decoding them.
#pragma once

#include <cstddef>
#include <span>

namespace fire3dv::convert {

// Whether all segments are in bounds, and the file is a kind that all decoders read: Huffman-coded, 8 bits,
// grey or three components, baseline to progressive, with its tables, and ends with an end marker. Other
// files may be readable, too.
bool is_sound_jpeg(std::span<const std::byte> bytes);

}  // namespace fire3dv::convert
