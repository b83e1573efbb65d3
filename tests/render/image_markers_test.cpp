// Render test of image markers, of markers beside other outputs, and of culling. Pixels are computed by hand
// from the pinhole camera: a point (x, y, -z) lies at the pixel (32 + 100 x / z, 24 - 100 y / z).
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/render/support/marker_fixture.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

const glm::ivec3 kBlackMarker(0);

// On 0.4 x 0.2 m at 1 m: 40 x 20 pixels from (2, 14) to (42, 34).
Marker image_of(wire::MarkerImage image) {
  Marker marker;
  marker.kind = MarkerKind::images;
  marker.positions = {{-0.1f, 0, -1}};
  marker.sizes = {{0.4f, 0.2f, 0}};
  marker.image = std::move(image);
  return marker;
}

// 4 x 2 pixels: texels of 10 pixels, whose centres are those of pixels.
const std::array<glm::ivec3, 8> kColors{{{255, 0, 0},
                                         {0, 255, 0},
                                         {0, 0, 255},
                                         {10, 200, 77},
                                         {255, 255, 0},
                                         {0, 0, 0},
                                         {128, 64, 32},
                                         {255, 255, 255}}};
wire::MarkerImage eight_colors() {
  wire::MarkerImage image{4, 2, 3, {}};
  for (const glm::ivec3& color : kColors)
    for (int i = 0; i < 3; ++i) image.pixels.push_back(static_cast<uint8_t>(color[i]));
  return image;
}

using ImageMarkers = MarkerTest;

INSTANTIATE_TEST_SUITE_P(Paths, ImageMarkers,
                         testing::Values(settings::RasterPath::visibility, settings::RasterPath::forward),
                         [](const auto& test) {
                           return test.param == settings::RasterPath::forward ? "forward" : "visibility";
                         });

TEST_P(ImageMarkers, BothSidesShowExactPixels) {
  Marker marker = image_of(eight_colors());
  const sinks::FrameImage front = draw(marker);
  for (uint32_t row = 0; row < 2; ++row)
    for (uint32_t column = 0; column < 4; ++column)
      EXPECT_EQ(pixel(front, 7 + 10 * column, 19 + 10 * row), kColors[4 * row + column]) << column << row;
  EXPECT_EQ(pixel(front, 3, 14 + 1), kColors[0]) << "edges repeat";
  EXPECT_EQ(pixel(front, 1, 19), kBlackMarker);
  EXPECT_EQ(pixel(front, 7, 12), kBlackMarker);
  EXPECT_EQ(pixel(front, 7, 36), kBlackMarker);
  EXPECT_NE(pixel(front, 41, 19), kBlackMarker);
  EXPECT_NE(pixel(front, 43, 19), kColors[3]);
  marker.rotations = {{0, 1, 0, 0}};  // half a turn about y
  const sinks::FrameImage back = draw(marker);
  for (uint32_t column = 0; column < 4; ++column)
    EXPECT_EQ(pixel(back, 7 + 10 * column, 19), kColors[3 - column]) << column;
}

TEST_P(ImageMarkers, GreyAndAlphaFormats) {
  wire::MarkerImage grey{4, 1, 1, {0, 90, 200, 255}};
  const sinks::FrameImage image = draw(image_of(grey));
  for (uint32_t i = 0; i < 4; ++i) EXPECT_EQ(pixel(image, 7 + 10 * i, 24), glm::ivec3(grey.pixels[i])) << i;
  wire::MarkerImage clear{4, 1, 4, {}};
  for (const uint8_t alpha : {0, 128, 255, 255}) clear.pixels.insert(clear.pixels.end(), {255, 0, 0, alpha});
  const sinks::FrameImage blended = draw(image_of(clear));
  EXPECT_EQ(pixel(blended, 4, 24), kBlackMarker);
  EXPECT_NEAR(pixel(blended, 17, 24).r, 255 * (1.055 * std::pow(128.0 / 255.0, 1 / 2.4) - 0.055), 1);
  EXPECT_EQ(pixel(blended, 32, 24), glm::ivec3(255, 0, 0));
}

TEST_P(ImageMarkers, MinifiedPixelsAreAveraged) {
  wire::MarkerImage board{256, 128, 1, {}};  // 6.4 pixels of it in each pixel
  for (uint32_t i = 0; i < 256 * 128; ++i) board.pixels.push_back((i % 256 / 4 + i / 256 / 4) % 2 ? 255 : 0);
  const sinks::FrameImage image = draw(image_of(board));
  double sum = 0;
  for (uint32_t y = 18; y < 30; ++y)
    for (uint32_t x = 6; x < 36; ++x) {
      const double value = pixel(image, x, y).r / 255.0;
      EXPECT_GT(pixel(image, x, y).r, 40) << x << " " << y;
      sum += value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    }
  EXPECT_NEAR(sum / (12 * 30), 0.5, 0.02);
}

TEST_P(ImageMarkers, SurfacesHideImagesUnlessOverlaid) {
  Marker marker = image_of(eight_colors());
  marker.positions = {{0.6f, 0, -3}};  // around the pixel (52, 24), behind the block
  const glm::ivec3 grey = pixel(draw(marker), 48, 22);
  EXPECT_TRUE(grey.r == grey.g && grey.r > 0);
  marker.flags = wire::kMarkerOverlaid;
  EXPECT_NE(pixel(draw(marker), 48, 22), grey);
  // One image on several places, of several sizes.
  marker = image_of({1, 1, 3, {255, 0, 0}});
  marker.positions = {{-0.2f, 0.1f, -1}, {0, -0.1f, -1}};  // (12, 14), (32, 34)
  marker.sizes = {{0.1f, 0.1f, 0}, {0.04f, 0.04f, 0}};
  const sinks::FrameImage two = draw(marker);
  EXPECT_EQ(pixel(two, 8, 14), glm::ivec3(255, 0, 0));
  EXPECT_EQ(pixel(two, 33, 34), glm::ivec3(255, 0, 0));
  EXPECT_EQ(pixel(two, 28, 34), kBlackMarker);
}

TEST_P(ImageMarkers, LargestImageIsUploadedOnce) {
  wire::MarkerImage image{1024, 1024, 4, std::vector<uint8_t>(size_t{4} << 20, 200)};
  show(image_of(image));
  (void)draw();
  const uint64_t uploaded = bench_.renderer().counts().uploaded_marker_bytes;
  EXPECT_GE(uploaded, uint64_t{4} << 20);
  (void)draw();
  EXPECT_EQ(bench_.renderer().counts().uploaded_marker_bytes, uploaded);
}

TEST_P(ImageMarkers, OnlyColourOutputsHaveMarkers) {
  if (GetParam() == settings::RasterPath::forward) return;  // has colours only
  const passes::ImageOutputs outputs(wire::kColorSrgb8 | wire::kDepthF32 | wire::kInstanceU32);
  const Taken without = bench_.take(poses_, view(), outputs);
  show(image_of(eight_colors()));
  const sinks::FrameImage expected = draw();  // requests them from now on
  const Taken with = bench_.take(poses_, view(), outputs);
  EXPECT_EQ(with.image.rgba8, expected.rgba8);
  EXPECT_NE(with.image.rgba8, without.image.rgba8);
  EXPECT_EQ(with.planes, without.planes) << "depth and labels";
}

Marker random_marker(MarkerKind kind, std::mt19937& random) {
  const auto number = [&](float from, float to) { return std::uniform_real_distribution(from, to)(random); };
  const float z = number(-3, 0.5f), reach = 0.6f * std::max(std::abs(z), 0.2f);
  const glm::vec3 centre(number(-reach, reach), number(-reach, reach), z);
  Marker marker;
  marker.kind = kind;
  marker.width = number(1, 12);
  const size_t count = kind == MarkerKind::triangles ? 3 : 2;
  for (size_t i = 0; i < count; ++i)
    marker.positions.push_back({centre.x + number(-0.1f, 0.1f), centre.y + number(-0.1f, 0.1f), centre.z});
  if (kind == MarkerKind::points && number(0, 1) < 0.5f) {
    marker.width_unit = wire::MarkerUnit::lengths;
    marker.width = number(0.01f, 0.2f);
  }
  if (wire::has_sizes(kind)) {
    for (size_t i = 0; i < count; ++i)
      marker.sizes.push_back({number(0, 0.2f), number(0, 0.2f), number(0, 0.2f)});
    marker.rotations = {{number(-1, 1), number(-1, 1), number(-1, 1), 1}};
  }
  if (kind == MarkerKind::images) marker.image = {1, 1, 3, {255, 255, 255}};
  return marker;
}

// Adds an element in the middle of the image that covers nothing: the marker is then in view.
Marker with_element_in_view(Marker marker) {
  const size_t count = marker.positions.size();
  if (marker.kind != MarkerKind::images) marker.colors.assign(count, 0xffffffff);
  const size_t more = marker.kind == MarkerKind::triangles                                    ? 3
                      : marker.kind == MarkerKind::lines || marker.kind == MarkerKind::arrows ? 2
                                                                                              : 1;
  for (size_t i = 0; i < more; ++i) {
    marker.positions.push_back({0, 0, -1});
    if (!marker.colors.empty()) marker.colors.push_back(0);
    if (!marker.sizes.empty()) marker.sizes.push_back({0, 0, 0});
  }
  return marker;
}

TEST_P(ImageMarkers, CullingKeepsVisibleMarkers) {
  std::mt19937 random(7);
  size_t culled = 0, seen = 0;
  const sinks::FrameImage empty = draw();
  for (const MarkerKind kind :
       {MarkerKind::points, MarkerKind::lines, MarkerKind::axes, MarkerKind::boxes, MarkerKind::spheres,
        MarkerKind::capsules, MarkerKind::triangles, MarkerKind::images}) {
    for (int i = 0; i < 12; ++i) {
      const Marker marker = random_marker(kind, random);
      const sinks::FrameImage image = draw(marker);
      if (bench_.renderer().counts().markers == 0) {
        ++culled;
        ASSERT_EQ(image.rgba8, empty.rgba8);
        ASSERT_LE(largest_difference(draw(with_element_in_view(marker)), empty), 1)
            << wire::marker_kind_name(kind) << i;
      } else if (image.rgba8 != empty.rgba8) {
        ++seen;
      }
    }
  }
  EXPECT_GT(culled, 20u);
  EXPECT_GT(seen, 20u);
}

TEST_P(ImageMarkers, VisibleOfManyAreDrawn) {
  for (int i = 0; i < 1000; ++i) {
    Marker marker;
    marker.width = 1;
    marker.positions = {{0.1f * static_cast<float>(i), 0, -1}};  // pixels 32, 42, 52, 62, 72 ...
    show(std::move(marker));
  }
  (void)draw();
  EXPECT_EQ(bench_.renderer().counts().markers, 4u);
  shown_.erase(shown_.begin());
  (void)draw();
  EXPECT_EQ(bench_.renderer().counts().markers, 3u);
  const uint64_t uploaded = bench_.renderer().counts().uploaded_marker_bytes;
  (void)draw();
  EXPECT_EQ(bench_.renderer().counts().uploaded_marker_bytes, uploaded);
}

}  // namespace
}  // namespace fire3dv::test
