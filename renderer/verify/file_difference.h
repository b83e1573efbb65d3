// First difference of an image's stored files and those that are drawn again.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "renderer/sinks/frame.h"

namespace fire3dv::verify {

// "pixel (3, 4) is 255 0 0 in the file and 254 0 0 here": x and y count from the top left pixel, from 0.
// nullopt: sizes and pixels are equal. Alpha is named where it differs.
std::optional<std::string> pixel_difference(const sinks::FrameImage& stored, const sinks::FrameImage& drawn);

// stored: untrusted bytes. name: of the file; its ending decides what is compared: pixels of PNG (text chunks
// may differ), elements of NumPy files, fields of JSON, values in lines of text, else bytes. nullopt: they
// are equal.
std::optional<std::string> file_difference(std::string_view name, std::span<const uint8_t> stored,
                                           std::span<const uint8_t> drawn);

// Lines of frames.jsonl. stored: untrusted. The sizes of files ("bytes") may differ.
std::optional<std::string> line_difference(const std::string& stored, const std::string& drawn);

}  // namespace fire3dv::verify
