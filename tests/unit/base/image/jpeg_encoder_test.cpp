// JPEG files as another decoder (stb_image) reads them.
#include "base/image/jpeg_encoder.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#include <stb/stb_image.h>

namespace fire3dv {
namespace {

class JpegEncoderChroma : public testing::TestWithParam<Chroma> {};
INSTANTIATE_TEST_SUITE_P(Both, JpegEncoderChroma, testing::Values(Chroma::half, Chroma::full));

struct FreeImage {
  void operator()(unsigned char* pixels) const { stbi_image_free(pixels); }
};

TEST_P(JpegEncoderChroma, ChangingSizesDecode) {
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
    const auto bytes = encoder.encode(pixels.data(), width, height, stride, 95, GetParam());
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

TEST_P(JpegEncoderChroma, InvalidSizeIsAnError) {
  JpegEncoder encoder;
  std::vector<uint8_t> noise(4 * 128 * 128);
  uint32_t state = 1;
  for (uint8_t& byte : noise) byte = static_cast<uint8_t>((state = state * 1664525 + 1013904223) >> 24);
  const auto fine = encoder.encode(noise.data(), 128, 128, 4 * 128, 100, GetParam());
  ASSERT_TRUE(fine);
  const size_t fine_size = fine->size();
  const auto coarse = encoder.encode(noise.data(), 128, 128, 4 * 128, 10, GetParam());
  ASSERT_TRUE(coarse);
  EXPECT_LT(4 * coarse->size(), fine_size);
  const auto empty = encoder.encode(noise.data(), 0, 0, 0, 90, GetParam());
  ASSERT_FALSE(empty);
  EXPECT_NE(empty.error().message.find("cannot be encoded as JPEG"), std::string::npos);
  EXPECT_TRUE(encoder.encode(noise.data(), 128, 128, 4 * 128, 10, GetParam()))
      << "the encoder works again after an error";
}

// Red and blue columns of one pixel: half the resolution mixes them.
TEST(JpegEncoder, FullChromaKeepsPixelColours) {
  constexpr uint32_t kSide = 32;
  std::vector<uint8_t> pixels;
  for (uint32_t i = 0; i < kSide * kSide; ++i)
    for (const int value : {i % 2 == 0 ? 255 : 0, 0, i % 2 == 0 ? 0 : 255, 0})
      pixels.push_back(static_cast<uint8_t>(value));
  const auto red_of_first = [&](Chroma chroma) {
    JpegEncoder encoder;
    const auto bytes = encoder.encode(pixels.data(), kSide, kSide, 4 * kSide, 95, chroma);
    int w = 0, h = 0, channels = 0;
    const std::unique_ptr<unsigned char, FreeImage> decoded(
        stbi_load_from_memory(bytes->data(), static_cast<int>(bytes->size()), &w, &h, &channels, 3));
    return decoded ? decoded.get()[3 * (kSide * 8 + 8)] : 0;
  };
  EXPECT_GT(red_of_first(Chroma::full), 240);
  EXPECT_LT(red_of_first(Chroma::half), 200);
}

}  // namespace
}  // namespace fire3dv
