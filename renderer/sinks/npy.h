// NumPy .npy writer (format version 1.0) for image planes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/base/atomic_file.h"
#include "protocol/base/error.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

// Encodes an array of shape (height, width), or (height, width, channels) for several channels.
std::vector<uint8_t> encode_npy(const FramePlane& plane, uint32_t width, uint32_t height);

// Writes the file atomically. The error names the path.
Result<void> write_npy(const std::filesystem::path& path, const FramePlane& plane, uint32_t width,
                       uint32_t height, base::Durability durability = base::Durability::contents_and_name);

}  // namespace fire3dv::sinks
