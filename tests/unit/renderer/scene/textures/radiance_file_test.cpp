// Test of the Radiance HDR reader and of packed environment images: decoded values, and refusals of damaged
// files.
#include "renderer/scene/textures/environment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

const std::string kHeader = "#?RADIANCE\n# made by a test\nFORMAT=32-bit_rle_rgbe\n\n";

std::string sized(uint32_t width, uint32_t height) {
  return kHeader + "-Y " + std::to_string(height) + " +X " + std::to_string(width) + "\n";
}

Result<EnvironmentImage> decode(const std::string& text) {
  return decode_radiance_file(std::as_bytes(std::span(text)), "test.hdr");
}

std::string bytes(std::initializer_list<int> values) {
  std::string text;
  for (const int value : values) text += static_cast<char>(value);
  return text;
}

void expect_refused(const std::string& text, const std::string& reason) {
  const Result<EnvironmentImage> result = decode(text);
  ASSERT_FALSE(result.ok()) << "expected: " << reason;
  EXPECT_NE(result.error().message.find(reason), std::string::npos) << result.error().message;
  EXPECT_NE(result.error().message.find("test.hdr"), std::string::npos) << result.error().message;
}

TEST(RadianceFile, FlatPixelsAreRead) {
  const Result<EnvironmentImage> image =
      decode(sized(2, 2) + bytes({128, 64, 32, 129, 0, 0, 0, 0, 255, 0, 0, 136, 1, 2, 4, 128}));
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->width, 2u);
  EXPECT_EQ(image->height, 2u);
  EXPECT_EQ(image->scale, 1);
  EXPECT_EQ(unpack_rgb9e5(image->rgb9e5[0]), glm::vec3(1, 0.5f, 0.25f));
  EXPECT_EQ(unpack_rgb9e5(image->rgb9e5[1]), glm::vec3(0));
  EXPECT_EQ(unpack_rgb9e5(image->rgb9e5[2]), glm::vec3(255, 0, 0));
  EXPECT_EQ(unpack_rgb9e5(image->rgb9e5[3]), glm::vec3(1, 2, 4) / 256.0f);
}

TEST(RadianceFile, BothRunKindsAreRead) {
  // Planar run lengths: a run of 8, then 8 single values, then both mixed.
  const std::string planes =
      bytes({2, 2, 0, 8, 136, 128, 8, 1, 2, 3, 4, 5, 6, 7, 8, 132, 7, 4, 1, 2, 3, 4, 136, 136});
  const Result<EnvironmentImage> by_planes = decode(sized(8, 1) + planes);
  ASSERT_TRUE(by_planes.ok()) << by_planes.error().message;
  EXPECT_EQ(unpack_rgb9e5(by_planes->rgb9e5[0]), glm::vec3(128, 1, 7));
  EXPECT_EQ(unpack_rgb9e5(by_planes->rgb9e5[7]), glm::vec3(128, 8, 4));
  // Old run lengths by pixel: one pixel, repeated 2 + 1 * 256 times.
  const Result<EnvironmentImage> by_pixels =
      decode(sized(259, 1) + bytes({8, 8, 8, 136, 1, 1, 1, 2, 1, 1, 1, 1}));
  ASSERT_TRUE(by_pixels.ok()) << by_pixels.error().message;
  for (const uint32_t texel : by_pixels->rgb9e5) ASSERT_EQ(unpack_rgb9e5(texel), glm::vec3(8));
}

TEST(RadianceFile, ExposureIsTakenOut) {
  const Result<EnvironmentImage> image =
      decode("#?RGBE\r\nFORMAT=32-bit_rle_rgbe\r\nEXPOSURE= 2\r\nEXPOSURE=4\r\n\r\n-Y 1 +X 1\r\n" +
             bytes({128, 128, 128, 132}));
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(unpack_rgb9e5(image->rgb9e5[0]), glm::vec3(1));
}

TEST(RadianceFile, ClampedSunKeepsEnergy) {
  const Result<EnvironmentImage> image = decode(sized(2, 1) + bytes({200, 100, 0, 145, 128, 0, 0, 129}));
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_GT(image->scale, 1);
  EXPECT_EQ(unpack_rgb9e5(image->rgb9e5[0]) * image->scale, glm::vec3(200, 100, 0) * 512.0f);
  EXPECT_EQ(unpack_rgb9e5(image->rgb9e5[1]) * image->scale, glm::vec3(1, 0, 0));
  // The brightest value of the format is clamped, not infinite.
  const Result<EnvironmentImage> extreme = decode(sized(1, 1) + bytes({255, 255, 255, 255}));
  ASSERT_TRUE(extreme.ok());
  EXPECT_EQ(unpack_rgb9e5(extreme->rgb9e5[0]), glm::vec3(kMaxRgb9e5));
}

TEST(RadianceFile, InvalidHeadersAreRefused) {
  expect_refused("", "is not a Radiance image");
  expect_refused("\x89PNG\r\n", "is not a Radiance image");
  expect_refused("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "the header does not end");
  expect_refused("#?RADIANCE\n" + std::string(1 << 20, '\n').replace(0, 1, "x"), "lacks FORMAT");
  expect_refused("#?RADIANCE\n" + std::string(1 << 20, 'x'), "the header does not end");
  expect_refused("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1234", "save it as 32-bit_rle_rgbe");
  expect_refused("#?RADIANCE\n\n-Y 1 +X 1\n1234", "lacks FORMAT");
  for (const char* exposure : {"nan", "inf", "0", "-1", "1e30", "", "one"}) {
    expect_refused(
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=" + std::string(exposure) + "\n\n-Y 1 +X 1\n1234",
        "exposure");
  }
  for (const char* size :
       {"+Y 1 +X 1", "-Y 1", "-Y 1 +X", "-Y -1 +X 1", "-Y 1 +X 1 ", "-Y 99999999999 +X 1", "+X 1 -Y 1"}) {
    expect_refused(kHeader + size + "\n1234", "the size is to read");
  }
  expect_refused(kHeader, "the size is to read");
  expect_refused(sized(0, 1), "from 1 x 1 to 8192 x 4096");
  expect_refused(sized(8193, 4096), "from 1 x 1 to 8192 x 4096");
  expect_refused(sized(4294967295, 4294967295), "from 1 x 1 to 8192 x 4096");
  expect_refused(sized(8192, 4096) + "1234", "ends early");
}

TEST(RadianceFile, DamagedRowsAreRefused) {
  const std::string good = sized(8, 1) + bytes({2, 2, 0, 8, 136, 1, 136, 2, 136, 3, 136, 136});
  ASSERT_TRUE(decode(good).ok());
  for (size_t cut = sized(8, 1).size() + 4; cut < good.size(); ++cut)
    expect_refused(good.substr(0, cut), "row 0 is damaged");
  expect_refused(sized(8, 1) + bytes({2, 2, 0, 9, 136, 1, 136, 2, 136, 3, 136, 136}),
                 "row 0 is damaged");  // other width
  expect_refused(sized(8, 1) + bytes({2, 2, 0, 8, 137, 1, 136, 2, 136, 3, 136, 136}),
                 "row 0 is damaged");  // run beyond the row
  expect_refused(sized(8, 1) + bytes({2, 2, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0}),
                 "row 0 is damaged");  // run of length 0
  expect_refused(sized(4, 1) + bytes({1, 1, 1, 4, 0, 0, 0, 0}),
                 "row 0 is damaged");  // repeats a missing pixel
  expect_refused(sized(4, 1) + bytes({9, 9, 9, 9, 1, 1, 1, 4}), "row 0 is damaged");  // too many repetitions
  expect_refused(sized(4, 1) + bytes({9, 9, 9, 9, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0}),
                 "row 0 is damaged");
  expect_refused(sized(1, 2) + bytes({9, 9, 9, 9, 9, 9, 9}), "row 1 is damaged");
}

TEST(RadianceFile, MissingFilesAreNamed) {
  const test::ScratchFolder folder;
  const Result<EnvironmentImage> missing = load_environment(folder.path() / "none.hdr");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().message.find("none.hdr"), std::string::npos);
  EXPECT_FALSE(load_environment(folder.path()).ok());  // a folder
  EXPECT_TRUE(load_environment(folder.write("one.hdr", sized(1, 1) + bytes({1, 2, 3, 128}))).ok());
  const Result<EnvironmentImage> neither = load_environment(folder.write("one.png", test::png(1, 1, 0)));
  ASSERT_FALSE(neither.ok());
  EXPECT_NE(neither.error().message.find("one.png is neither a Radiance nor an OpenEXR image"),
            std::string::npos)
      << neither.error().message;
}

TEST(EnvironmentImage, PackingRoundsToNineBits) {
  for (const float value : {1.0f, 0.5f, 1e-4f, 0.7f, 3.14159f, 1000.0f, 65000.0f}) {
    const glm::vec3 color(value, value * 0.5f, value * 0.25f);
    const glm::vec3 back = unpack_rgb9e5(pack_rgb9e5(color));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(back[c], color[c], value / 512) << value;
  }
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(unpack_rgb9e5(pack_rgb9e5({std::nanf(""), -1, infinity})), glm::vec3(0, 0, kMaxRgb9e5));
  EXPECT_EQ(unpack_rgb9e5(pack_rgb9e5({1e-30f, 0, -0.0f})), glm::vec3(0));
  EXPECT_EQ(unpack_rgb9e5(pack_rgb9e5(glm::vec3(0.99999f))), glm::vec3(1));  // one bit more after rounding
}

TEST(EnvironmentImage, CentreIsAhead) {
  EXPECT_NEAR(glm::distance(environment_direction(0.5f, 0.5f), {0, 0, -1}), 0, 1e-6f);
  EXPECT_NEAR(glm::distance(environment_direction(0.75f, 0.5f), {1, 0, 0}), 0, 1e-6f);
  EXPECT_NEAR(glm::distance(environment_direction(0.3f, 0), {0, 1, 0}), 0, 1e-6f);
}

}  // namespace
}  // namespace fire3dv::scene
