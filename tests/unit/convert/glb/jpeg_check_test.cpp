// Test of the structure check of JPEG files: a whole file is copied without decoding, truncated and unusual
// ones are not sound, and no damage makes it read out of bounds.
#include "convert/glb/jpeg_check.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "convert/glb/write_glb.h"

namespace fire3dv::convert {
namespace {

// 8 x 8 grey pixels, encoded by FFmpeg.
constexpr std::string_view kHex =
    "ffd8ffe000104a46494600010200000100010000ffdb004300080404040404050505050505060606060606060606060606060707"
    "0708"
    "080807070706060707080808080909090808080809090a0a0a0c0c0b0b0e0e0e111114ffc4004a00010000000000000000000000"
    "0000"
    "00000001010000000000000000000000000000000010010000000000000000000000000000000011010000000000000000000000"
    "0000"
    "000000ffc00011080008000803011200021200031200ffda000c03010002110311003f00000fffd9";

std::vector<std::byte> jpeg() {
  const auto digit = [](char c) { return static_cast<unsigned>(c <= '9' ? c - '0' : c - 'a' + 10); };
  std::vector<std::byte> bytes;
  for (size_t i = 0; i + 2 <= kHex.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(digit(kHex[i]) * 16 + digit(kHex[i + 1])));
  return bytes;
}

TEST(JpegCheck, WholeFilesAreCopied) {
  const Image image{"grey.jpg", jpeg()};
  EXPECT_TRUE(is_sound_jpeg(image.bytes));
  uint64_t pixels_left = 100;
  const Result<GlbImage> made = glb_image(image, pixels_left);
  ASSERT_TRUE(made.ok()) << made.error().message;
  EXPECT_EQ(made->mime_type, "image/jpeg");
  EXPECT_EQ(made->bytes.data(), image.bytes.data());
  EXPECT_EQ(made->bytes.size(), image.bytes.size());
  EXPECT_EQ(pixels_left, 36u);
}

TEST(JpegCheck, BytesBehindEndAreAllowed) {
  std::vector<std::byte> bytes = jpeg();
  bytes.resize(bytes.size() + 1000, std::byte{7});
  EXPECT_TRUE(is_sound_jpeg(bytes));
}

TEST(JpegCheck, NoTruncatedFileIsSound) {
  const std::vector<std::byte> bytes = jpeg();
  for (size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(is_sound_jpeg(std::span(bytes).first(size))) << size;
}

TEST(JpegCheck, UnsupportedJpegsAreInvalid) {
  const std::vector<std::byte> bytes = jpeg();
  const auto changed = [&](size_t place, unsigned value) {
    std::vector<std::byte> copy = bytes;
    copy[place] = static_cast<std::byte>(value);
    return is_sound_jpeg(copy);
  };
  const size_t frame = bytes.size() - 37;
  ASSERT_EQ(bytes[frame + 1], std::byte{0xc0});
  EXPECT_TRUE(changed(frame + 1, 0xc2)) << "progressive";
  for (const unsigned marker : {0xc3u, 0xc9u, 0xc5u, 0xdau})
    EXPECT_FALSE(changed(frame + 1, marker)) << marker;
  EXPECT_FALSE(changed(frame + 4, 12)) << "12 bits";
  EXPECT_FALSE(changed(frame + 9, 4)) << "four components";
  EXPECT_FALSE(changed(21, 0xe1)) << "no quantization table";
}

TEST(JpegCheck, DamageStaysWithinBounds) {
  const std::vector<std::byte> bytes = jpeg();
  size_t sound = 0;
  for (size_t place = 0; place < bytes.size(); ++place)
    for (const unsigned value : {0x00u, 0x01u, 0x7fu, 0xd8u, 0xffu}) {
      std::vector<std::byte> copy = bytes;
      copy[place] = static_cast<std::byte>(value);
      sound += is_sound_jpeg(copy);
    }
  EXPECT_GT(sound, 0u);
  EXPECT_LT(sound, 5 * bytes.size());
}

}  // namespace
}  // namespace fire3dv::convert
