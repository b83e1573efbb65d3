// Pixels of ROS images: rows without padding.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <vector>

#include "adapters/ros2/images/image_bytes.h"

namespace fire3dv::ros2 {
namespace {

TEST(ImageBytes, RgbWithoutPadding) {
  constexpr uint32_t kStride = 16;  // three pixels and a gap
  std::vector<uint8_t> rows(2 * kStride, 99);
  for (uint8_t y = 0; y < 2; ++y)
    for (uint8_t x = 0; x < 3; ++x)
      for (uint8_t c = 0; c < 4; ++c)
        rows[y * kStride + 4u * x + c] = static_cast<uint8_t>(100 * y + 10 * x + c);
  std::vector<uint8_t> rgb(100);
  pack_rgb8({FIRE3DV_IMAGE_COLOR_SRGB8, 3, 2, kStride, rows.data()}, rgb);
  EXPECT_EQ(rgb, (std::vector<uint8_t>{0, 1, 2, 10, 11, 12, 20, 21, 22, 100, 101, 102, 110, 111, 112, 120,
                                       121, 122}));
}

TEST(ImageBytes, DepthAndLabelsWithoutPadding) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float rows[2][4] = {{1.5f, 2.5f, kInfinity, -1}, {3.5f, 4.5f, 5.5f, -1}};
  std::vector<uint8_t> bytes;
  pack_32bit({FIRE3DV_IMAGE_DEPTH_F32, 3, 2, sizeof rows[0], rows}, bytes);
  ASSERT_EQ(bytes.size(), 24u);
  float depth[6];
  std::memcpy(depth, bytes.data(), sizeof depth);
  EXPECT_EQ(std::vector<float>(depth, depth + 6),
            (std::vector<float>{1.5f, 2.5f, kInfinity, 3.5f, 4.5f, 5.5f}));
  const uint8_t one_and_a_half[4] = {0, 0, 0xC0, 0x3F};  // little endian
  EXPECT_EQ(std::memcmp(bytes.data(), one_and_a_half, 4), 0);
  pack_32bit({FIRE3DV_IMAGE_INSTANCE_U32, 0, 0, 0, nullptr}, bytes);
  EXPECT_TRUE(bytes.empty());
}

}  // namespace
}  // namespace fire3dv::ros2
