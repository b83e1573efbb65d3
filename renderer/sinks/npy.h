// Planes of numbers as .npy files, which NumPy opens by numpy.load (format version 1.0).
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/base/atomic_file.h"
#include "protocol/error.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

// An array of height x width numbers, or of height x width x channels where there are several.
std::vector<uint8_t> encode_npy(const FramePlane& plane, uint32_t width, uint32_t height);

// The error names the path. The file is complete or absent.
Result<void> write_npy(const std::filesystem::path& path, const FramePlane& plane, uint32_t width,
                       uint32_t height, base::Durability durability = base::Durability::contents_and_name);

}  // namespace fire3dv::sinks
