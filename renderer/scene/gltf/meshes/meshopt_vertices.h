// Decoders of KHR_meshopt_compression that EXT_meshopt_compression lacks, and older versions of
// meshoptimizer, too: version 1 of the vertex codec, and the filter COLOR.
#pragma once

#include <cstddef>
#include <span>

namespace fire3dv::scene {

// True if the stream is of version 1.
bool is_vertex_stream_v1(std::span<const std::byte> stream);

// Decodes `count` elements of `stride` bytes (a multiple of 4 up to 256). False if the stream is damaged.
bool decode_vertices_v1(std::byte* to, size_t count, size_t stride, std::span<const std::byte> stream);

// Converts YCoCg colours with a scale in the alpha's highest bit to RGBA, in place. component_bytes: 1 or 2.
void decode_color_filter(std::byte* colors, size_t count, size_t component_bytes);

}  // namespace fire3dv::scene
