// Test of the image comparison with planted differences: the limits of each tolerance preset.
#include <gtest/gtest.h>
#include <unistd.h>

#include <concepts>
#include <cstdlib>
#include <filesystem>

#include "renderer/sinks/png.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

namespace fs = std::filesystem;
using sinks::FrameImage;

static_assert(!std::is_default_constructible_v<Tolerance>);
static_assert(!std::constructible_from<Tolerance, const char*, int, double>, "no third preset");

FrameImage grey(uint32_t width, uint32_t height) {
  FrameImage image;
  image.width = width;
  image.height = height;
  image.rgba8.assign(size_t{4} * width * height, 128);
  return image;
}

class ImageCompare : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("fire3dv_compare_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "goldens");
    setenv("FIRE3DV_GOLDEN_DIR", (folder_ / "goldens").c_str(), 1);
    setenv("FIRE3DV_TEST_IMAGE_DIR", (folder_ / "images").c_str(), 1);
  }
  void TearDown() override {
    fs::remove_all(folder_);
    unsetenv("FIRE3DV_GOLDEN_DIR");
    unsetenv("FIRE3DV_TEST_IMAGE_DIR");
  }
  void bless(const FrameImage& image, const std::string& name) {
    ASSERT_TRUE(sinks::write_png(folder_ / "goldens" / (name + ".png"), image).ok());
  }
  bool evidence(const std::string& file) const { return fs::exists(folder_ / "images" / file); }
  fs::path folder_;
};

// 100 x 100 pixels: 0.1 % are ten pixels.
TEST_F(ImageCompare, TheSameImagePassesBoth) {
  bless(grey(100, 100), "same");
  EXPECT_TRUE(matches_golden(grey(100, 100), "same", Tolerance::exact()));
  EXPECT_TRUE(matches_golden(grey(100, 100), "same", Tolerance::colour()));
  EXPECT_FALSE(fs::exists(folder_ / "images")) << "nothing is written for an image that is right";
}

TEST_F(ImageCompare, ExactCatchesOneBit) {
  bless(grey(100, 100), "bit");
  for (const size_t byte : {size_t{0}, size_t{3}, size_t{4 * 100 * 100 - 1}}) {
    FrameImage image = grey(100, 100);
    image.rgba8[byte] ^= 1;
    const auto result = matches_golden(image, "bit", Tolerance::exact());
    EXPECT_FALSE(result);
    EXPECT_NE(std::string(result.message()).find("1 of 10000 pixels"), std::string::npos) << result.message();
    EXPECT_TRUE(matches_golden(image, "bit", Tolerance::colour()));
  }
}

TEST_F(ImageCompare, ColourCatchesShift) {
  bless(grey(100, 100), "shift");
  FrameImage image = grey(100, 100);
  for (uint8_t& byte : image.rgba8) byte = 128 + 5;
  EXPECT_TRUE(matches_golden(image, "shift", Tolerance::colour()));
  for (uint8_t& byte : image.rgba8) byte = 128 - 6;
  EXPECT_FALSE(matches_golden(image, "shift", Tolerance::colour()));
}

TEST_F(ImageCompare, ColourAllowsTenInTenThousand) {
  bless(grey(100, 100), "edge");
  FrameImage image = grey(100, 100);
  for (size_t pixel = 0; pixel < 10; ++pixel) image.rgba8[4 * (997 * pixel) + 1] = 255;
  EXPECT_TRUE(matches_golden(image, "edge", Tolerance::colour()));
  image.rgba8[4 * 9999] = 0;
  const auto result = matches_golden(image, "edge", Tolerance::colour());
  EXPECT_FALSE(result);
  EXPECT_NE(std::string(result.message()).find("11 of 10000"), std::string::npos) << result.message();
  EXPECT_NE(std::string(result.message()).find("128/255 at x 99, y 99"), std::string::npos)
      << result.message();
  EXPECT_TRUE(evidence("edge.actual.png"));
  EXPECT_TRUE(evidence("edge.difference.png"));
  const auto difference = sinks::read_png(folder_ / "images" / "edge.difference.png");
  ASSERT_TRUE(difference.ok());
  EXPECT_EQ(difference->image.rgba8[1], 255);
  EXPECT_EQ(difference->image.rgba8[4 * 5000], 0);
}

TEST_F(ImageCompare, MissingGoldenFails) {
  const auto result = matches_golden(grey(8, 8), "unheard_of", Tolerance::colour());
  EXPECT_FALSE(result);
  EXPECT_TRUE(evidence("unheard_of.new.png"));
  EXPECT_FALSE(fs::exists(folder_ / "goldens" / "unheard_of.png")) << "a test never blesses";
  EXPECT_NE(std::string(result.message()).find("unheard_of.new.png"), std::string::npos);
}

TEST_F(ImageCompare, AnotherSizeFails) {
  bless(grey(100, 100), "size");
  EXPECT_FALSE(matches_golden(grey(100, 99), "size", Tolerance::colour()));
  EXPECT_TRUE(evidence("size.actual.png"));
  EXPECT_FALSE(matches_golden(FrameImage{}, "size", Tolerance::colour()));
}

TEST_F(ImageCompare, NoImageMatchesNothing) {
  EXPECT_FALSE(matches_image(FrameImage{}, FrameImage{}, "empty", Tolerance::exact()));
}

TEST_F(ImageCompare, NamesCannotLeaveTheFolder) {
  EXPECT_FALSE(matches_golden(grey(8, 8), "../x", Tolerance::colour()));
  EXPECT_FALSE(fs::exists(folder_ / "x.new.png"));
}

}  // namespace
}  // namespace fire3dv::test
