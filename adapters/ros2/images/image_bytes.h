// Pixels as sensor_msgs/Image has them: rows without padding, little endian.
#pragma once

#include <fire3dv/image.h>

#include <cstdint>
#include <vector>

namespace fire3dv::ros2 {

// RGB of a FIRE3DV_IMAGE_COLOR_SRGB8 plane, 3 bytes a pixel. Reuses the memory of `rgb`.
void pack_rgb8(const fire3dv_image_plane& plane, std::vector<uint8_t>& rgb);

// Elements of 4 bytes: depth (32FC1, metres) and labels (32SC1). Reuses the memory of `bytes`.
void pack_32bit(const fire3dv_image_plane& plane, std::vector<uint8_t>& bytes);

}  // namespace fire3dv::ros2
