// Test of PNG files: written images round-trip with their frame tags, and the reader is safe against hostile
// files.
#include <gtest/gtest.h>
#include <zlib.h>

#include <unistd.h>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "renderer/sinks/output_text.h"
#include "renderer/sinks/png.h"

namespace fire3dv::sinks {
namespace {

FrameImage gradient(uint32_t width, uint32_t height, uint8_t alpha) {
  FrameImage image;
  image.width = width;
  image.height = height;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      image.rgba8.insert(image.rgba8.end(), {static_cast<uint8_t>(7 * x), static_cast<uint8_t>(5 * y),
                                             static_cast<uint8_t>(x ^ y), alpha});
    }
  }
  return image;
}

state::FrameTag tag(std::string name, uint64_t epoch, uint64_t sequence, int64_t sim_time_ns) {
  state::FrameTag result;
  result.stream = std::move(name);
  result.epoch = epoch;
  result.sequence = sequence;
  result.sim_time_ns = sim_time_ns;
  result.publish_time_ns = 42 + sequence;
  return result;
}

std::string text_at(const PngFile& file, std::string_view keyword) {
  for (const auto& [key, value] : file.text) {
    if (key == keyword) return value;
  }
  return "(absent)";
}

void append_u32(std::vector<uint8_t>& out, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<uint8_t>(value >> shift));
}
void append_chunk(std::vector<uint8_t>& out, const char* type, const std::vector<uint8_t>& body) {
  append_u32(out, static_cast<uint32_t>(body.size()));
  const size_t start = out.size();
  out.insert(out.end(), type, type + 4);
  out.insert(out.end(), body.begin(), body.end());
  append_u32(out, static_cast<uint32_t>(crc32(0, out.data() + start, static_cast<uInt>(out.size() - start))));
}
// A PNG whose header claims a size without data.
std::vector<uint8_t> png_claiming(uint32_t width, uint32_t height) {
  std::vector<uint8_t> out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::vector<uint8_t> header;
  append_u32(header, width);
  append_u32(header, height);
  header.insert(header.end(), {8, 6, 0, 0, 0});
  append_chunk(out, "IHDR", header);
  append_chunk(out, "IDAT", {0x78, 0x9c, 0x03, 0x00, 0x00, 0x00, 0x00, 0x01});
  append_chunk(out, "IEND", {});
  return out;
}

TEST(Png, PixelsComeBackBitForBit) {
  for (const uint8_t alpha : {uint8_t{255}, uint8_t{128}}) {
    const FrameImage image = gradient(37, 21, alpha);
    const auto bytes = encode_png(image);
    ASSERT_TRUE(bytes.ok()) << bytes.error().message;
    const auto file = decode_png(*bytes);
    ASSERT_TRUE(file.ok()) << file.error().message;
    EXPECT_EQ(file->image.width, 37u);
    EXPECT_EQ(file->image.height, 21u);
    EXPECT_EQ(file->image.rgba8, image.rgba8);
    EXPECT_TRUE(file->srgb);
    EXPECT_EQ((*bytes)[25], alpha == 255 ? 2 : 6) << "opaque images need no alpha channel";
  }
}

TEST(Png, SameImageGivesSameBytes) {
  EXPECT_EQ(*encode_png(gradient(64, 64, 255)), *encode_png(gradient(64, 64, 255)));
}

TEST(Png, SaysWhatOneStreamShows) {
  FrameImage image = gradient(4, 4, 255);
  image.camera = "camera_front";
  image.frame_index = 17;
  image.shown = {tag("bullet_arm", 0xfedcba9876543210u, 18446744073709551615u, -5)};
  image.shown[0].condition = state::Condition::lost;
  const auto file = decode_png(*encode_png(image));
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(text_at(*file, "Software").substr(0, 8), "FIRE-3DV");
  EXPECT_EQ(text_at(*file, "Camera"), "camera_front");
  EXPECT_EQ(text_at(*file, "Frame"), "17");
  EXPECT_EQ(text_at(*file, "Streams"), "1");
  EXPECT_EQ(text_at(*file, "Stream"), "bullet_arm");
  EXPECT_EQ(text_at(*file, "Epoch"), "fedcba9876543210");
  EXPECT_EQ(text_at(*file, "Sequence"), "18446744073709551615");
  EXPECT_EQ(text_at(*file, "SimTimeNs"), "-5");
  EXPECT_EQ(text_at(*file, "State"), "lost");
  EXPECT_EQ(file->image.camera, "camera_front");
  EXPECT_EQ(file->image.frame_index, 17u);
  ASSERT_EQ(file->image.shown.size(), 1u);
  EXPECT_EQ(file->image.shown[0].stream, "bullet_arm");
  EXPECT_EQ(file->image.shown[0].epoch, 0xfedcba9876543210u);
  EXPECT_EQ(file->image.shown[0].sequence, 18446744073709551615u);
  EXPECT_EQ(file->image.shown[0].sim_time_ns, -5);
  EXPECT_EQ(file->image.shown[0].condition, state::Condition::lost);
}

TEST(Png, SeveralStreamsAreNumbered) {
  FrameImage image = gradient(4, 4, 255);
  image.shown = {tag("left", 1, 10, 100), tag("right", 2, 20, 200)};
  const auto file = decode_png(*encode_png(image));
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(text_at(*file, "Stream.0"), "left");
  EXPECT_EQ(text_at(*file, "Sequence.1"), "20");
  EXPECT_EQ(text_at(*file, "State.0"), "live");
  EXPECT_EQ(text_at(*file, "Stream"), "(absent)");
  ASSERT_EQ(file->image.shown.size(), 2u);
  EXPECT_EQ(file->image.shown[1].stream, "right");
  EXPECT_EQ(file->image.shown[1].sim_time_ns, 200);
}

TEST(Png, ASceneAtRestSaysSo) {
  const auto file = decode_png(*encode_png(gradient(4, 4, 255)));
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(text_at(*file, "Streams"), "0");
  EXPECT_EQ(text_at(*file, "Camera"), "(absent)");
  EXPECT_TRUE(file->image.shown.empty());
}

TEST(Png, PathTracedImageNamesItsSettings) {
  FrameImage image = gradient(4, 4, 255);
  image.path_traced = PathTraced{256, 8, 4294967295u};
  const auto file = decode_png(*encode_png(image));
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(file->image.path_traced, image.path_traced);
  EXPECT_EQ(text_at(*file, "Renderer"), "path");
  EXPECT_EQ(text_at(*file, "SamplesPerPixel"), "256");
  EXPECT_EQ(text_at(*file, "Bounces"), "8");
  EXPECT_EQ(text_at(*file, "Seed"), "4294967295");
  const auto raster = decode_png(*encode_png(gradient(4, 4, 255)));
  ASSERT_TRUE(raster.ok());
  EXPECT_FALSE(raster->image.path_traced);
  EXPECT_EQ(text_at(*raster, "Renderer"), "(absent)");
}

TEST(Png, HiddenStreamsAreNamed) {
  FrameImage image = gradient(4, 4, 255);
  image.hidden_streams = {"arm", "cloud\n"};
  const auto file = decode_png(*encode_png(image));
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(text_at(*file, "HiddenStream"), "arm");
  EXPECT_EQ(file->image.hidden_streams, (std::vector<std::string>{"arm", "cloud?"}));
}

TEST(Png, NamesFromOutsideAreMadeFit) {
  FrameImage image = gradient(4, 4, 255);
  image.camera = "K\xc3\xa4mera \xe2\x82\xac";  // valid UTF-8 stays
  image.shown = {
      tag(std::string("a\0b\n\x1b[31m\xff\xc0\xaf", 13), 1, 1, 1)};  // NUL, control, invalid, overlong UTF-8
  const auto file = decode_png(*encode_png(image));
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(file->image.camera, "K\xc3\xa4mera \xe2\x82\xac");
  EXPECT_EQ(file->image.shown[0].stream, "a?b??[31m???" + std::string("?"));
  image.shown[0].stream = std::string(100000, 'x');
  EXPECT_EQ(decode_png(*encode_png(image))->image.shown[0].stream, std::string(4096, 'x'));
}

TEST(Png, RefusesAnImageThatIsNone) {
  EXPECT_FALSE(encode_png(FrameImage{}).ok());
  FrameImage image = gradient(4, 4, 255);
  image.width = 5;
  EXPECT_FALSE(encode_png(image).ok());
}

TEST(PngReader, EveryCutIsRefused) {
  const std::vector<uint8_t> bytes = *encode_png(gradient(16, 16, 200));
  ASSERT_TRUE(decode_png(bytes).ok());
  for (size_t size = 0; size < bytes.size(); ++size) {
    const auto file = decode_png(std::span(bytes).first(size));
    ASSERT_FALSE(file.ok()) << "cut at " << size << " of " << bytes.size();
    ASSERT_FALSE(file.error().message.empty());
  }
}

TEST(PngReader, FlippedBitsAreHarmless) {
  std::vector<uint8_t> bytes = *encode_png(gradient(16, 16, 200));
  size_t refused = 0;
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<uint8_t>(1u << (bit % 8));
    if (!decode_png(bytes).ok()) ++refused;
    bytes[bit / 8] ^= static_cast<uint8_t>(1u << (bit % 8));
  }
  EXPECT_GT(refused, 8 * bytes.size() * 9 / 10) << "CRCs cover nearly all of the file";
}

TEST(PngReader, RandomBytesAreRefused) {
  std::mt19937 random(7);
  for (int round = 0; round < 2000; ++round) {
    std::vector<uint8_t> bytes = png_claiming(16, 16);
    bytes.resize(33);  // signature and IHDR
    const size_t more = random() % 300;
    for (size_t i = 0; i < more; ++i) bytes.push_back(static_cast<uint8_t>(random()));
    ASSERT_FALSE(decode_png(bytes).ok());
  }
}

TEST(PngReader, ClaimedSizeAllocatesNothing) {
  for (const auto& [width, height] :
       {std::pair{0x7fffffffu, 0x7fffffffu}, {32769u, 1u}, {1u, 32769u}, {30000u, 30000u}, {0u, 4u}}) {
    const auto file = decode_png(png_claiming(width, height));
    EXPECT_FALSE(file.ok()) << width << " x " << height;
  }
  EXPECT_FALSE(decode_png(*encode_png(gradient(16, 16, 255)), PngLimits{.max_side = 8}).ok());
  EXPECT_FALSE(decode_png(*encode_png(gradient(16, 16, 255)), PngLimits{.max_pixels = 255}).ok());
  EXPECT_TRUE(decode_png(*encode_png(gradient(16, 16, 255)), PngLimits{.max_pixels = 256}).ok());
}

TEST(PngReader, LongChunkIsRefusedEarly) {
  std::vector<uint8_t> bytes = png_claiming(16, 16);
  for (const char* type : {"tEXt", "iTXt", "zTXt", "iCCP", "PLTE", "IDAT", "abCd"}) {
    std::vector<uint8_t> claim(bytes.begin(), bytes.begin() + 33);
    append_u32(claim, 0x7ffffff0);
    for (const char c : std::string(type) + std::string(100, 'x')) claim.push_back(static_cast<uint8_t>(c));
    const auto file = decode_png(claim);
    ASSERT_FALSE(file.ok()) << type;
    EXPECT_NE(file.error().message.find("cut short"), std::string::npos) << file.error().message;
  }
}

TEST(PngReader, StreamCountIsChecked) {
  FrameImage image;
  apply_text({{"Streams", "99999999999"}, {"Stream.3", "x"}}, image);
  EXPECT_TRUE(image.shown.empty());
  apply_text(
      {{"Streams", "2"}, {"Stream.7", "x"}, {"Stream.-1", "x"}, {"Stream.", "x"}, {"Sequence.1", "12 "}},
      image);
  ASSERT_EQ(image.shown.size(), 2u);
  EXPECT_EQ(image.shown[1].sequence, 0u) << "a number with something behind it is no number";
}

TEST(PngFiles, FilesAreWholeOrAbsent) {
  const auto folder = std::filesystem::temp_directory_path() / ("fire3dv_png_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto path = folder / "image.png";
  ASSERT_TRUE(write_png(path, gradient(8, 8, 255)).ok());
  EXPECT_TRUE(read_png(path).ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1) << "nothing else is left";
  const auto missing = read_png(folder / "missing.png");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().message.find("missing.png"), std::string::npos);
  EXPECT_FALSE(read_png(folder).ok()) << "a folder is not a file";
  const auto nowhere = write_png(path / "below" / "x.png", gradient(8, 8, 255));
  ASSERT_FALSE(nowhere.ok());
  EXPECT_NE(nowhere.error().message.find("x.png"), std::string::npos);
  std::ofstream(folder / "other.png") << "not a png at all";
  EXPECT_FALSE(read_png(folder / "other.png").ok());
  std::filesystem::remove_all(folder);
}

TEST(SinkText, FileNamesCannotLeaveFolder) {
  EXPECT_EQ(safe_file_name("camera_front"), "camera_front");
  EXPECT_EQ(safe_file_name("../../etc/passwd"), "_.._.._etc_passwd");
  EXPECT_EQ(safe_file_name(".."), "_..");
  EXPECT_EQ(safe_file_name(""), "_");
  EXPECT_EQ(safe_file_name("a b\0c"), "a_b");
  EXPECT_LE(safe_file_name(std::string(5000, 'x')).size(), 101u);
}

TEST(SinkText, JsonStringsAreEscaped) {
  EXPECT_EQ(json_string("a\"b\\c\nd"), "\"a\\\"b\\\\c?d\"");
  EXPECT_EQ(json_string("\xed\xa0\x80"), "\"???\"") << "surrogates are not UTF-8";
}

}  // namespace
}  // namespace fire3dv::sinks
