#include "adapters/ros2/images/image_bytes.h"

#include <cstddef>
#include <cstring>

namespace fire3dv::ros2 {

void pack_rgb8(const fire3dv_image_plane& plane, std::vector<uint8_t>& rgb) {
  const size_t width = plane.width, height = plane.height;
  rgb.resize(3 * width * height);
  uint8_t* to = rgb.data();
  for (size_t row = 0; row < height; ++row) {
    const uint8_t* from = static_cast<const uint8_t*>(plane.data) + row * plane.row_stride;
    for (size_t column = 0; column < width; ++column, from += 4, to += 3) {
      to[0] = from[0];
      to[1] = from[1];
      to[2] = from[2];
    }
  }
}

void pack_32bit(const fire3dv_image_plane& plane, std::vector<uint8_t>& bytes) {
  const size_t row_bytes = size_t{4} * plane.width;
  bytes.resize(row_bytes * plane.height);
  for (size_t row = 0; row < plane.height && row_bytes > 0; ++row)
    std::memcpy(&bytes[row * row_bytes], static_cast<const uint8_t*>(plane.data) + row * plane.row_stride,
                row_bytes);
}

}  // namespace fire3dv::ros2
