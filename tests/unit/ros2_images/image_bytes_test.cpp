// Pixels of ROS images: rows without padding, and JPEG as another decoder (stb_image) reads it.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#include <stb/stb_image.h>

#include "adapters/ros2/images/image_bytes.h"
#include "adapters/ros2/images/jpeg_encoder.h"

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

struct FreeImage {
  void operator()(unsigned char* pixels) const { stbi_image_free(pixels); }
};

TEST(JpegEncoder, ImagesOfChangingSizesDecode) {
  JpegEncoder encoder;
  for (const auto& [width, height] : {std::pair{64u, 48u}, {7u, 5u}, {300u, 200u}, {1u, 1u}}) {
    const size_t stride = 4 * width + 12;
    std::vector<uint8_t> pixels(stride * height, 200);
    for (uint32_t y = 0; y < height; ++y) {
      for (uint32_t x = 0; x < width; ++x) {
        uint8_t* const pixel = &pixels[y * stride + 4 * x];
        pixel[0] = static_cast<uint8_t>(255 * x / width);
        pixel[1] = static_cast<uint8_t>(255 * y / height);
        pixel[2] = 30;
      }
    }
    const auto bytes = encoder.encode(pixels.data(), width, height, stride, 95);
    ASSERT_TRUE(bytes) << bytes.error().message;
    int w = 0, h = 0, channels = 0;
    const std::unique_ptr<unsigned char, FreeImage> decoded(
        stbi_load_from_memory(bytes->data(), static_cast<int>(bytes->size()), &w, &h, &channels, 3));
    ASSERT_TRUE(decoded) << stbi_failure_reason();
    ASSERT_EQ(w, static_cast<int>(width));
    ASSERT_EQ(h, static_cast<int>(height));
    double squares = 0;
    for (uint32_t y = 0; y < height; ++y) {
      for (uint32_t x = 0; x < width; ++x) {
        for (uint32_t c = 0; c < 3; ++c) {
          const double difference = pixels[y * stride + 4 * x + c] - decoded.get()[3 * (y * width + x) + c];
          squares += difference * difference;
        }
      }
    }
    EXPECT_LT(squares / (3.0 * width * height), width > 10 ? 4 : 200) << width << "x" << height;
  }
}

TEST(JpegEncoder, QualityChangesTheSizeAndABadSizeIsAnError) {
  JpegEncoder encoder;
  std::vector<uint8_t> noise(4 * 128 * 128);
  uint32_t state = 1;
  for (uint8_t& byte : noise) byte = static_cast<uint8_t>((state = state * 1664525 + 1013904223) >> 24);
  const auto fine = encoder.encode(noise.data(), 128, 128, 4 * 128, 100);
  ASSERT_TRUE(fine);
  const size_t fine_size = fine->size();
  const auto coarse = encoder.encode(noise.data(), 128, 128, 4 * 128, 10);
  ASSERT_TRUE(coarse);
  EXPECT_LT(4 * coarse->size(), fine_size);
  const auto empty = encoder.encode(noise.data(), 0, 0, 0, 90);
  ASSERT_FALSE(empty);
  EXPECT_NE(empty.error().message.find("cannot be encoded as JPEG"), std::string::npos);
  EXPECT_TRUE(encoder.encode(noise.data(), 128, 128, 4 * 128, 10))
      << "the encoder works again after an error";
}

}  // namespace
}  // namespace fire3dv::ros2
