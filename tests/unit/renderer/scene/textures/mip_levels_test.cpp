// Test of mip level generation: sizes, means in linear light, and rounding.
#include "renderer/scene/textures/images.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace fire3dv::scene {
namespace {

Image image_of(uint32_t width, uint32_t height, std::vector<uint8_t> rgba8) {
  return {.name = "", .width = width, .height = height, .rgba8 = std::move(rgba8)};
}

double light_of(double code) {
  const double s = code / 255;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}
double code_of(double light) {
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

TEST(MipLevels, SidesHalveToOne) {
  const auto sizes = [](uint32_t width, uint32_t height) {
    std::vector<size_t> texels;
    for (const std::vector<uint8_t>& level : generate_mip_levels(
             image_of(width, height, std::vector<uint8_t>(size_t{4} * width * height)), false))
      texels.push_back(level.size() / 4);
    return texels;
  };
  EXPECT_EQ(sizes(8, 8), (std::vector<size_t>{16, 4, 1}));
  EXPECT_EQ(sizes(5, 3), (std::vector<size_t>{2, 1}));
  EXPECT_EQ(sizes(1, 4), (std::vector<size_t>{2, 1}));
  EXPECT_EQ(sizes(1, 1), std::vector<size_t>{});
}

TEST(MipLevels, AreMeansOfLight) {
  const Image image = image_of(2, 2, {0, 10, 255, 0, 255, 11, 255, 255, 0, 10, 255, 1, 255, 10, 255, 255});
  EXPECT_EQ(generate_mip_levels(image, false)[0], (std::vector<uint8_t>{128, 10, 255, 128}));
  EXPECT_EQ(generate_mip_levels(image, true)[0], (std::vector<uint8_t>{188, 10, 255, 128}));
}

TEST(MipLevels, OddTexelsWeighEqually) {
  const Image row = image_of(5, 1, {100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 100, 50, 50, 50, 50});
  EXPECT_EQ(generate_mip_levels(row, false)[0], (std::vector<uint8_t>{40, 40, 20, 0, 20, 20, 40, 60}));
}

// All sizes of both kinds, each level from the one before.
TEST(MipLevels, LevelsMatchDoublePrecision) {
  std::mt19937 random(5);
  for (uint32_t width = 1; width < 12; ++width) {
    for (uint32_t height = 1; height < 12; ++height) {
      for (const bool srgb : {false, true}) {
        Image image = image_of(width, height, std::vector<uint8_t>(size_t{4} * width * height));
        for (uint8_t& value : image.rgba8.edit()) value = static_cast<uint8_t>(random());
        for (const std::vector<uint8_t>& level : generate_mip_levels(image, srgb)) {
          const uint32_t w = std::max(image.width / 2, 1u), h = std::max(image.height / 2, 1u);
          ASSERT_EQ(level.size(), size_t{4} * w * h);
          const double across = double(image.width) / w, down = double(image.height) / h;
          for (uint32_t i = 0; i < level.size(); ++i) {
            const uint32_t c = i % 4, x = i / 4 % w, y = i / 4 / w;
            const bool light = srgb && c != 3;
            double sum = 0;
            for (uint32_t v = 0; v < image.height; ++v) {
              for (uint32_t u = 0; u < image.width; ++u) {
                const double share_x = std::min((x + 1) * across, u + 1.0) - std::max(x * across, double(u));
                const double share_y = std::min((y + 1) * down, v + 1.0) - std::max(y * down, double(v));
                const double value = image.rgba8[4 * (v * image.width + u) + c];
                sum += std::max(share_x, 0.0) * std::max(share_y, 0.0) * (light ? light_of(value) : value);
              }
            }
            const double mean = sum / (across * down);
            ASSERT_NEAR(level[i], light ? code_of(mean) : mean, 0.53) << width << " x " << height;
          }
          image = image_of(w, h, level);
        }
      }
    }
  }
}

TEST(MipLevels, OneColourStaysThatColour) {
  for (const uint32_t side : {6u, 7u, 512u}) {
    for (uint32_t code = 0; code < 256; ++code) {
      const Image image =
          image_of(side, 2, std::vector<uint8_t>(size_t{8} * side, static_cast<uint8_t>(code)));
      const std::vector<uint8_t> smaller = generate_mip_levels(image, true)[0];
      ASSERT_TRUE(std::all_of(smaller.begin(), smaller.end(), [&](uint8_t c) { return c == code; })) << code;
    }
  }
}

}  // namespace
}  // namespace fire3dv::scene
