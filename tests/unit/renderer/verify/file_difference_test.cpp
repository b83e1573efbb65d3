// Unit test of the first difference of stored files and those that are drawn again.
#include "renderer/verify/file_difference.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "renderer/dataset/layouts/image_files.h"
#include "renderer/sinks/file_sink.h"
#include "renderer/sinks/gray_png.h"
#include "renderer/sinks/png.h"
#include "renderer/verify/json_difference.h"

namespace fire3dv::verify {
namespace {

using Bytes = std::vector<uint8_t>;

sinks::FrameImage image_of(uint8_t green, uint8_t alpha = 255) {
  sinks::FrameImage image;
  image.width = 3;
  image.height = 2;
  image.rgba8.assign(24, 7);
  for (size_t i = 3; i < 24; i += 4) image.rgba8[i] = 255;
  image.rgba8[4 * 4 + 1] = green;  // pixel (1, 1)
  image.rgba8[4 * 4 + 3] = alpha;
  return image;
}

Bytes png_of(sinks::FrameImage image, const std::string& camera = "") {
  image.camera = camera;
  return sinks::encode_png(image).value();
}

Bytes bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}

TEST(FileDifference, NamesThePixelOfColours) {
  EXPECT_EQ(file_difference("a.png", png_of(image_of(9)), png_of(image_of(9), "other text")), std::nullopt);
  EXPECT_EQ(file_difference("a.png", png_of(image_of(9)), png_of(image_of(8))),
            "pixel (1, 1) is 7 9 7 in the file and 7 8 7 here");
  EXPECT_EQ(file_difference("a.png", png_of(image_of(9, 3)), png_of(image_of(9))),
            "pixel (1, 1) is 7 9 7 3 in the file and 7 9 7 255 here");
  sinks::FrameImage wide = image_of(9);
  wide.width = 2;
  wide.height = 3;
  EXPECT_EQ(file_difference("a.png", png_of(wide), png_of(image_of(9))),
            "the size is 2x3 in the file and 3x2 here");
  EXPECT_NE(file_difference("a.png", bytes_of("no image"), png_of(image_of(9))), std::nullopt);
}

TEST(FileDifference, NamesThePixelOfDepth) {
  std::vector<uint16_t> depth{0, 1, 2, 3, 4, 50000};
  const Bytes before = dataset::encode_gray_png(depth, 3, 2);
  EXPECT_EQ(sinks::decode_gray16(before, 100)->pixels, depth);
  depth[4] = 5;
  EXPECT_EQ(file_difference("a.png", before, dataset::encode_gray_png(depth, 3, 2)),
            "pixel (1, 1) is 4 in the file and 5 here");
  EXPECT_FALSE(sinks::decode_gray16(before, 5).has_value());
  // The same high bytes in 8 bits are another image.
  const Bytes dark = dataset::encode_gray_png(std::vector<uint16_t>{0, 1, 2, 3, 4, 5}, 3, 2);
  sinks::FrameImage black;
  black.width = 3;
  black.height = 2;
  for (int i = 0; i < 6; ++i) black.rgba8.insert(black.rgba8.end(), {0, 0, 0, 255});
  EXPECT_EQ(file_difference("a.png", png_of(black), dark), "it is not a grey image of 16 bits in both");
  EXPECT_EQ(file_difference("a.png", dark, png_of(black)), "it is not a grey image of 16 bits in both");
  for (size_t bytes = 0; bytes < before.size(); ++bytes)
    (void)sinks::decode_gray16(std::span(before).first(bytes), 100);
  EXPECT_FALSE(sinks::decode_gray16(png_of(image_of(1)), 100).has_value());
}

TEST(FileDifference, NamesTheElementOfArrays) {
  const auto npy = [](const char* type, const std::vector<uint64_t>& shape,
                      const std::vector<float>& values) {
    return sinks::encode_npy(
        type, shape, {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(float)});
  };
  const Bytes one = npy("<f4", {2, 3}, {0, 1, 2, 3, 4, 5});
  EXPECT_EQ(file_difference("a.npy", one, npy("<f4", {2, 3}, {0, 1, 2, 3.5, 4, 5})),
            "pixel (0, 1) is 3 in the file and 3.5 here");
  EXPECT_EQ(file_difference("a.npy", npy("<f4", {1, 3, 2}, {0, 1, 2, 3, 4, 5}),
                            npy("<f4", {1, 3, 2}, {0, 1, 2, -3, 4, 5})),
            "pixel (1, 0), channel 1, is 3 in the file and -3 here");
  EXPECT_EQ(file_difference("a.npy", one, npy("<f4", {3, 2}, {0, 1, 2, 3, 4, 5})),
            "type or shape of the array differs");
  EXPECT_EQ(file_difference("a.npy", Bytes(3), one), "type or shape of the array differs");
}

TEST(FileDifference, NamesTheLineOfTexts) {
  EXPECT_EQ(file_difference("a.json", bytes_of("a\nbc\n"), bytes_of("a\nbd\n")),
            "line 2 is \"c\" in the file and \"d\" here");
  EXPECT_EQ(file_difference("pose.txt", bytes_of("1,2\n1,2.25,3\n"), bytes_of("1,2\n1,2.5,3\n")),
            "line 2, value 2 is 2.25 in the file and 2.5 here");
  EXPECT_EQ(file_difference("a.txt", bytes_of("1 2"), bytes_of("1 2\n1 3\n")),
            "line 1 is \"\" in the file and \"\" here");
  EXPECT_EQ(file_difference("a.hdf5", bytes_of("abc"), bytes_of("abd")), "byte 2 of 3 differs");
  EXPECT_EQ(file_difference("a.hdf5", bytes_of("ab"), bytes_of("abd")), "byte 2 of 2 differs");
}

TEST(FileDifference, NamesTheFieldOfLines) {
  EXPECT_EQ(line_difference(R"({"a":1,"bytes":[1]})", R"({"bytes":[2],"a":1})"), std::nullopt);
  EXPECT_EQ(line_difference(R"({"a":1})", R"({"a":[2]})"), "field \"a\" is 1 in the file and [2] here");
  EXPECT_EQ(line_difference(R"({"a":1,"b":2})", R"({"a":1})"),
            "field \"b\" is 2 in the file and absent here");
  EXPECT_EQ(line_difference(R"({"a":[{"b":1,"c":[1,2]},3]})", R"({"a":[{"b":1,"c":[1,4]},3]})"),
            "field \"a[0].c[1]\" is 2 in the file and 4 here");
  EXPECT_EQ(line_difference(R"({"a":{"b":1}})", R"({"a":{"c":1}})"),
            "field \"a.c\" is absent in the file and 1 here");
  EXPECT_EQ(line_difference(R"({"a":[1]})", R"({"a":[1,2]})"),
            "field \"a\" has 1 entry in the file and 2 entries here");
  EXPECT_EQ(line_difference(R"({"a":[1,3]})", R"({"a":[1,2,3]})"),
            "field \"a[1]\" is 3 in the file and 2 here");
  EXPECT_EQ(line_difference("7", R"({"a":1})"), "the line is no JSON object");
}

TEST(FileDifference, NamesTheFieldOfJsonFiles) {
  const auto difference = [](const std::string& stored, const std::string& drawn) {
    return file_difference("a.json", bytes_of(stored), bytes_of(drawn));
  };
  EXPECT_EQ(difference("{\"3\":[{\"x\":1}]}\n", "{\"3\":[{\"x\":1}]}\n"), std::nullopt);
  EXPECT_EQ(difference("{\"3\":[{\"x\":1}]}", "{\"3\":[{\"x\":2}]}"),
            "field \"3[0].x\" is 1 in the file and 2 here");
  EXPECT_EQ(difference("[1]", "[]"), "the value has 1 entry in the file and 0 entries here");
  // The same values in another form are other bytes.
  EXPECT_EQ(difference("{\"a\": 1}", "{\"a\":1}"), "line 1 is \" 1}\" in the file and \"1}\" here");
}

TEST(FileDifference, HostileJsonIsText) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  EXPECT_FALSE(parse_json(bytes_of(deep)).has_value());
  EXPECT_TRUE(file_difference("a.json", bytes_of(deep), bytes_of("[1]"))->starts_with("line 1"));
  EXPECT_FALSE(parse_json(bytes_of("[" + std::string(kMaxParsedBytes, ' ') + "]")).has_value());
  EXPECT_FALSE(parse_json(bytes_of("\"\xff\"")).has_value());
}

}  // namespace
}  // namespace fire3dv::verify
