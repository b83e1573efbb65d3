// Test of the OpenEXR reader of environments: agreement with Radiance files of the same image, a file of
// FFmpeg, windows, layers, limits and damaged files.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfEnvmap.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "base/files.h"
#include "renderer/scene/files.h"
#include "renderer/scene/textures/environment.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

// 8 x 4 pixels of halves, by `ffmpeg -f rawvideo -pix_fmt gbrpf32le -s 8x4 -i FILE -compression zip16 -format
// half`.
constexpr const char* kFileOfFfmpeg =
    "di8xAQIAAABjaGFubmVscwBjaGxpc3QANwAAAEIAAQAAAAAAAAABAAAAAQAAAEcAAQAAAAAAAAABAAAAAQAAAFIAAQAAAAAAAAAB"
    "AAAAAQAAAABjb21wcmVzc2lvbgBjb21wcmVzc2lvbgABAAAAA2RhdGFXaW5kb3cAYm94MmkAEAAAAAAAAAAAAAAABwAAAAMAAABk"
    "aXNwbGF5V2luZG93AGJveDJpABAAAAAAAAAAAAAAAAcAAAADAAAAbGluZU9yZGVyAGxpbmVPcmRlcgABAAAAAHNjcmVlbldpbmRv"
    "d0NlbnRlcgB2MmYACAAAAAAAAAAAAAAAc2NyZWVuV2luZG93V2lkdGgAZmxvYXQABAAAAAAAgD9mcmFtZXNQZXJTZWNvbmQAcmF0"
    "aW9uYWwACAAAABkAAAABAAAAZ2FtbWEAZmxvYXQABAAAAAAAgD93cml0ZXIAc3RyaW5nAAQAAABsYXZjAHEBAAAAAAAAAAAAAE0A"
    "AAB4nGNowAkCNqCLMAABNjFc4gcOHPgB5bbUQEDClpampsbGxsqGhtWhQPEOqPgMoFhjQ2NDOVR9D0y8oREMS6HiE6Di08CiDQ0A"
    "bVVYxQ==";
glm::vec3 pixel_of_ffmpeg(uint32_t x, uint32_t y) {
  return {0.25f * static_cast<float>(x) + static_cast<float>(y),
          std::ldexp(1.0f, static_cast<int>(y) - static_cast<int>(x)), x == 3 && y == 1 ? 1000.0f : 0.5f};
}

std::vector<glm::vec3> picture(uint32_t width, uint32_t height) {
  std::vector<glm::vec3> pixels;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const float light = std::ldexp(1.0f, static_cast<int>(x) % 9 - 4);
      pixels.push_back(light *
                       glm::vec3(1, 0.25f + 0.5f * static_cast<float>(y) / static_cast<float>(height), 0.7f));
    }
  }
  return pixels;
}

struct Written {
  uint32_t width = 0, height = 0;
  Imf::Compression compression = Imf::ZIP_COMPRESSION;
  Imf::PixelType type = Imf::FLOAT;
  std::array<std::string, 3> channels{"R", "G", "B"};
  bool is_tiled = false;
  Imath::V2i first{0, 0};                  // of the data window
  Imath::Box2i display;                    // empty: the data window
  std::vector<std::string> more_channels;  // without pixels of their own
  bool is_cube = false;
};

std::vector<std::byte> exr(const Written& wanted, const std::vector<glm::vec3>& pixels) {
  const test::ScratchFolder folder;
  const std::string path = (folder.path() / "image.exr").string();
  const Imath::Box2i data(wanted.first, wanted.first + Imath::V2i(static_cast<int>(wanted.width) - 1,
                                                                  static_cast<int>(wanted.height) - 1));
  Imf::Header header(wanted.display.isEmpty() ? data : wanted.display, data);
  header.compression() = wanted.compression;
  if (wanted.is_tiled) header.setTileDescription(Imf::TileDescription(8, 8));
  if (wanted.is_cube) Imf::addEnvmap(header, Imf::ENVMAP_CUBE);
  std::vector<Imath::half> halves;
  for (const glm::vec3& pixel : pixels) {
    for (int c = 0; c < 3; ++c) halves.emplace_back(pixel[c]);
  }
  const size_t size = wanted.type == Imf::HALF ? sizeof(Imath::half) : sizeof(float);
  Imf::FrameBuffer buffer;
  const auto add = [&](const std::string& name, size_t component) {
    header.channels().insert(name, Imf::Channel(wanted.type));
    const void* const from = wanted.type == Imf::HALF
                                 ? static_cast<const void*>(&halves[component])
                                 : static_cast<const void*>(&pixels[0][static_cast<int>(component)]);
    buffer.insert(name, Imf::Slice::Make(wanted.type, from, data, 3 * size, 3 * size * wanted.width));
  };
  for (size_t c = 0; c < 3; ++c) {
    if (!wanted.channels[c].empty()) add(wanted.channels[c], c);
  }
  for (const std::string& name : wanted.more_channels) add(name, 2);
  if (wanted.is_tiled) {
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  } else {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(static_cast<int>(wanted.height));
  }
  const auto bytes = read_file(path, 1 << 24);
  EXPECT_TRUE(bytes.ok());
  return {bytes->view().begin(), bytes->view().end()};
}

// Of a pixel's largest value: half a step of RGB9E5's 9 bits, and of half floats' 11 bits.
constexpr float kPrecision = 1.0f / 512 + 1.0f / 2048;

// The same image as a flat Radiance file.
std::vector<std::byte> radiance(uint32_t width, uint32_t height, const std::vector<glm::vec3>& pixels) {
  std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " +
                     std::to_string(width) + "\n";
  for (const glm::vec3& pixel : pixels) {
    const int exponent = std::ilogb(std::max({pixel.r, pixel.g, pixel.b})) + 1;
    for (int c = 0; c < 3; ++c) text += static_cast<char>(std::ldexp(pixel[c], 8 - exponent));
    text += static_cast<char>(exponent + 128);
  }
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

glm::vec3 at(const EnvironmentImage& image, size_t i) {
  return unpack_rgb9e5(image.rgb9e5[i]) * image.scale;
}

Result<EnvironmentImage> decoded(const std::vector<std::byte>& bytes) {
  return decode_openexr_file(bytes, "test.exr");
}

void expect_near(const glm::vec3& found, const glm::vec3& expected, float share) {
  const float most = share * std::max({expected.r, expected.g, expected.b});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], most);
}

TEST(OpenExrFile, ImageMatchesRadiance) {
  const std::vector<glm::vec3> pixels = picture(37, 21);
  const auto from_radiance = decode_radiance_file(radiance(37, 21, pixels), "test.hdr");
  ASSERT_TRUE(from_radiance.ok()) << from_radiance.error().message;
  for (const Imf::Compression compression :
       {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
        Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION, Imf::B44_COMPRESSION, Imf::DWAA_COMPRESSION}) {
    for (const Imf::PixelType type : {Imf::FLOAT, Imf::HALF}) {
      for (const bool is_tiled : {false, true}) {
        SCOPED_TRACE(testing::Message() << compression << " " << type << " " << is_tiled);
        Written written{37, 21, compression, type};
        written.is_tiled = is_tiled;
        const auto image = decoded(exr(written, pixels));
        ASSERT_TRUE(image.ok()) << image.error().message;
        ASSERT_EQ(image->width, 37u);
        ASSERT_EQ(image->height, 21u);
        EXPECT_EQ(image->scale, 1);
        const bool is_lossy = compression == Imf::B44_COMPRESSION || compression == Imf::DWAA_COMPRESSION;
        for (size_t i = 0; i < pixels.size(); ++i) {
          expect_near(at(*image, i), pixels[i], is_lossy ? 0.1f : kPrecision);
          // Radiance cuts values to 8 bits.
          if (!is_lossy) expect_near(at(*image, i), at(*from_radiance, i), 1.0f / 128 + 2 * kPrecision);
        }
      }
    }
  }
}

TEST(OpenExrFile, AFileOfFfmpeg) {
  const auto bytes = AssetFolder::none().read(std::string("data:;base64,") + kFileOfFfmpeg, 1 << 20);
  ASSERT_TRUE(bytes.ok());
  const auto image = decode_openexr_file(bytes->view(), "ffmpeg.exr");
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image->width, 8u);
  ASSERT_EQ(image->height, 4u);
  for (uint32_t y = 0; y < 4; ++y) {
    for (uint32_t x = 0; x < 8; ++x) expect_near(at(*image, 8 * y + x), pixel_of_ffmpeg(x, y), kPrecision);
  }
}

TEST(OpenExrFile, ClampedSunKeepsEnergy) {
  const auto image = decoded(exr({2, 1}, {{200000, 1, 0}, {1, 0, 0}}));
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_GT(image->scale, 1);
  expect_near(at(*image, 0), {200000, 1, 0}, kPrecision);
  EXPECT_EQ(at(*image, 1), glm::vec3(1, 0, 0));
  const float infinity = std::numeric_limits<float>::infinity(),
              none = std::numeric_limits<float>::quiet_NaN();
  const auto odd = decoded(exr({2, 1}, {{infinity, -1, none}, {3e38f, 0, 0}}));
  ASSERT_TRUE(odd.ok()) << odd.error().message;
  EXPECT_EQ(at(*odd, 0), glm::vec3(kMaxRgb9e5 * odd->scale, 0, 0));
}

TEST(OpenExrFile, DisplayWindowIsImage) {
  Written written{3, 2};
  written.first = {-1, 4};
  written.display = Imath::Box2i({0, 3}, {3, 4});
  const std::vector<glm::vec3> pixels{{1, 1, 1}, {2, 2, 2}, {4, 4, 4}, {8, 8, 8}, {16, 16, 16}, {32, 32, 32}};
  const auto image = decoded(exr(written, pixels));
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image->width, 4u);
  ASSERT_EQ(image->height, 2u);
  const std::vector<float> expected{0, 0, 0, 0, 2, 4, 0, 0};
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(at(*image, i), glm::vec3(expected[i])) << i;
}

TEST(OpenExrFile, LayerOrGreyChannels) {
  const std::vector<glm::vec3> pixels{{1, 2, 4}};
  Written layer{1, 1};
  layer.channels = {"Sky.Combined.R", "Sky.Combined.G", "Sky.Combined.B"};
  layer.more_channels = {"Depth.Z"};
  EXPECT_EQ(at(*decoded(exr(layer, pixels)), 0), glm::vec3(1, 2, 4));
  Written grey{1, 1};
  grey.channels = {"Y", "", ""};
  EXPECT_EQ(at(*decoded(exr(grey, pixels)), 0), glm::vec3(1));
  Written with_alpha{1, 1};
  with_alpha.more_channels = {"A", "Z.R"};
  EXPECT_EQ(at(*decoded(exr(with_alpha, pixels)), 0), glm::vec3(1, 2, 4));
}

TEST(OpenExrFile, UnsuitableFilesAreRefused) {
  const std::vector<glm::vec3> pixels = picture(1, 6);
  const auto reason = [&](const Written& written) {
    const auto image = decoded(exr(written, pixels));
    return image ? std::string("decoded") : image.error().message;
  };
  Written cube{1, 6};
  cube.is_cube = true;
  EXPECT_NE(reason(cube).find("is a cube map"), std::string::npos);
  Written depth{1, 1};
  depth.channels = {"Z", "", ""};
  EXPECT_EQ(reason(depth), "test.exr has no channels R, G and B");
  Written wide{1, 1};
  wide.display = Imath::Box2i({0, 0}, {8192, 0});
  EXPECT_EQ(reason(wide), "test.exr is 8193 x 1 pixels large; from 1 x 1 to 8192 x 4096 are read");
  wide.display = Imath::Box2i({0, 0}, {0, 4096});
  EXPECT_NE(reason(wide).find("1 x 4097"), std::string::npos);
  Written many{1, 1};
  for (int i = 0; i < 62; ++i) many.more_channels.push_back("c" + std::to_string(i));
  EXPECT_NE(reason(many).find("65 channels"), std::string::npos);

  const test::ScratchFolder folder;
  const auto missing = load_environment(folder.path() / "none.exr");
  ASSERT_FALSE(missing.ok());
  const auto written = load_environment(folder.write("one.dat", exr({1, 1}, pixels)));
  EXPECT_TRUE(written.ok()) << "its first bytes tell the format";
}

TEST(OpenExrFile, AttributesStayInside) {
  const std::string text("\x76\x2f\x31\x01\x02\0\0\0name\0string\0\xff\xff\xff\x7f", 24);
  const auto bytes = std::as_bytes(std::span(text));
  const auto image = decoded({bytes.begin(), bytes.end()});
  ASSERT_FALSE(image.ok());
  EXPECT_EQ(image.error().message, "test.exr: the header ends early; copy or save the file again");
}

TEST(OpenExrFile, DamagedFilesAreSafe) {
  const std::vector<glm::vec3> pixels = picture(9, 5);
  for (const bool is_tiled : {false, true}) {
    for (const Imf::Compression compression :
         {Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION, Imf::NO_COMPRESSION}) {
      Written written{9, 5, compression, Imf::HALF};
      written.is_tiled = is_tiled;
      const std::vector<std::byte> good = exr(written, pixels);
      size_t refused = 0;
      const auto decode = [&](std::span<const std::byte> bytes) {
        const auto image = decode_openexr_file(bytes, "test.exr");
        if (!image) {
          ++refused;
          EXPECT_NE(image.error().message.find("test.exr"), std::string::npos);
        } else {
          EXPECT_EQ(image->rgb9e5.size(), size_t{image->width} * image->height);
        }
      };
      for (size_t size = 0; size < good.size(); ++size) decode(std::span(good).first(size));
      EXPECT_EQ(refused, good.size());
      for (size_t i = 0; i < good.size(); ++i) {
        std::vector<std::byte> bytes = good;
        bytes[i] ^= static_cast<std::byte>(1 << (i % 8));
        decode(bytes);
      }
    }
  }
}

}  // namespace
}  // namespace fire3dv::scene
