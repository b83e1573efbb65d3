// Render test of markers. The places and colours of pixels are computed by hand from the pinhole camera: a
// point (x, y, -z) lies at the pixel (32 + 100 x / z, 24 - 100 y / z), whose centre is a whole number.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <string>

#include "tests/render/support/marker_fixture.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr uint32_t kRed = 0xff0000ff, kGreen = 0xff00ff00, kWhite = 0xffffffff;
const glm::ivec3 kBlack(0), kPureRed(255, 0, 0), kPureGreen(0, 255, 0);

Marker marker_of(MarkerKind kind, std::vector<std::array<float, 3>> positions, uint32_t color,
                 float width = 1) {
  Marker marker;
  marker.kind = kind;
  marker.positions = std::move(positions);
  marker.colors = {color};
  marker.width = width;
  return marker;
}

Marker solid(MarkerKind kind, std::array<float, 3> size) {
  Marker marker = marker_of(kind, {{0, 0, 0}}, kWhite);
  marker.sizes = {size};
  return marker;
}

using Markers = MarkerTest;

INSTANTIATE_TEST_SUITE_P(Paths, Markers,
                         testing::Values(settings::RasterPath::visibility, settings::RasterPath::forward),
                         [](const auto& test) {
                           return test.param == settings::RasterPath::forward ? "forward" : "visibility";
                         });

// Light of a channel, 1 for each fully covered pixel of colour 255.
double covered(const sinks::FrameImage& image, int channel, uint32_t x0, uint32_t y0, uint32_t x1,
               uint32_t y1) {
  double sum = 0;
  for (uint32_t y = y0; y < y1; ++y) {
    for (uint32_t x = x0; x < x1; ++x) {
      const double value = pixel(image, x, y)[channel] / 255.0;
      sum += value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    }
  }
  return sum;
}

TEST_P(Markers, PointDiameterIsInPixels) {
  const sinks::FrameImage image = draw(marker_of(MarkerKind::points, {{-0.1f, 0, -1}}, kRed, 9));
  for (uint32_t x = 18; x <= 26; ++x) EXPECT_EQ(pixel(image, x, kCy), kPureRed) << x;
  for (uint32_t y = 20; y <= 28; ++y) EXPECT_EQ(pixel(image, 22, y), kPureRed) << y;
  EXPECT_EQ(pixel(image, 17, kCy), kBlack);
  EXPECT_EQ(pixel(image, 27, kCy), kBlack);
  EXPECT_EQ(pixel(image, 18, 20), kBlack) << "the corner of the square around it";
  EXPECT_NEAR(covered(image, 0, 0, 0, 32, 49), std::numbers::pi * 4.5 * 4.5, 1);
}

TEST_P(Markers, SizeInLengthsShrinksWithDistance) {
  Marker marker = marker_of(MarkerKind::points, {{-0.1f, 0, -1}, {-0.1f, 0.2f, -2}}, kRed, 0.1f);
  marker.width_unit = wire::MarkerUnit::lengths;
  const sinks::FrameImage image = draw(marker);
  EXPECT_NEAR(covered(image, 0, 0, 19, 32, 49), std::numbers::pi * 25, 1.5);
  EXPECT_NEAR(covered(image, 0, 0, 0, 32, 19), std::numbers::pi * 6.25, 1);
  marker.positions.resize(1);
  marker.positions[0] = {-0.05f, 0, -0.5f};
  EXPECT_NEAR(covered(draw(marker, glm::scale(glm::mat4(1), glm::vec3(2))), 0, 0, 0, 36, 49),
              std::numbers::pi * 100, 4)
      << "the marker's frame has a unit of 2 metres";
}

TEST_P(Markers, LineHasWidthAndEnds) {
  Marker marker = marker_of(MarkerKind::lines, {{-0.2f, 0, -1}, {-0.1f, 0, -1}}, kGreen, 5);
  const sinks::FrameImage image = draw(marker);
  for (uint32_t y = 22; y <= 26; ++y) EXPECT_EQ(pixel(image, 17, y), kPureGreen) << y;
  EXPECT_EQ(pixel(image, 17, 21), kBlack);
  EXPECT_EQ(pixel(image, 17, 27), kBlack);
  EXPECT_EQ(pixel(image, 11, kCy), kBlack);
  EXPECT_EQ(pixel(image, 13, kCy), kPureGreen);
  EXPECT_EQ(pixel(image, 21, kCy), kPureGreen);
  EXPECT_EQ(pixel(image, 23, kCy), kBlack);
  EXPECT_NEAR(covered(image, 1, 0, 0, 32, 49), 50, 1);
  marker.width = 0.05f;
  marker.width_unit = wire::MarkerUnit::lengths;
  EXPECT_NEAR(covered(draw(marker), 1, 0, 0, 32, 49), 50, 1) << "0.05 m at 1 m";
  marker.kind = MarkerKind::line_strip;
  marker.width = 1;
  marker.width_unit = wire::MarkerUnit::pixels;
  marker.positions = {{-0.3f, 0.1f, -1}, {-0.1f, 0.1f, -1}, {-0.1f, -0.1f, -1}};
  const sinks::FrameImage strip = draw(marker);
  EXPECT_EQ(pixel(strip, 10, 14), kPureGreen);
  EXPECT_EQ(pixel(strip, 22, 24), kPureGreen);
  EXPECT_NEAR(covered(strip, 1, 0, 0, 32, 49), 42, 1.5);
}

TEST_P(Markers, LineIsCutAtNearPlane) {
  const sinks::FrameImage image =
      draw(marker_of(MarkerKind::lines, {{-0.1f, 0, -1}, {-0.1f, 0, 1}}, kGreen, 3));
  EXPECT_EQ(pixel(image, 21, kCy), kPureGreen);
  EXPECT_EQ(pixel(image, 0, kCy), kPureGreen) << "towards the viewer it leaves the image";
  shown_.clear();
  EXPECT_NEAR(covered(image, 1, 24, 0, 65, 49), covered(draw(), 1, 24, 0, 65, 49), 0.1)
      << "nothing is mirrored behind the viewer";
  EXPECT_EQ(draw(marker_of(MarkerKind::lines, {{0, 0, 1}, {0, 1, 2}}, kGreen, 3)).rgba8,
            draw(marker_of(MarkerKind::points, {{0, 0, 1}}, kGreen, 3)).rgba8)
      << "both are behind the viewer";
}

TEST_P(Markers, SurfacesHideMarkersUnlessOverlaid) {
  Marker behind = marker_of(MarkerKind::points, {{0.45f, 0, -3}}, kRed, 5);  // pixel (47, 24)
  const glm::ivec3 grey = pixel(draw(behind), 47, kCy);
  EXPECT_TRUE(grey.r == grey.g && grey.r > 0) << "the block";
  EXPECT_EQ(pixel(draw(marker_of(MarkerKind::points, {{0.285f, 0, -1.9f}}, kRed, 5)), 47, kCy), kPureRed);
  behind.flags = wire::kMarkerOverlaid;
  EXPECT_EQ(pixel(draw(behind), 47, kCy), kPureRed);
  shown_.clear();
  show(marker_of(MarkerKind::points, {{-0.1f, 0, -1}}, kRed, 5));
  show(marker_of(MarkerKind::points, {{-0.2f, 0, -2}}, kGreen, 9));
  EXPECT_EQ(pixel(draw(), 22, kCy), kPureRed) << "the nearer of two markers";
  EXPECT_EQ(pixel(draw(), 18, kCy), kPureGreen);
}

TEST_P(Markers, ColorsAreOfElementsAndBlend) {
  Marker marker = marker_of(MarkerKind::points, {{-0.2f, 0, -1}, {-0.1f, 0, -1}}, kRed, 5);
  marker.colors = {kGreen, 0x80ffffff};
  const sinks::FrameImage image = draw(marker);
  EXPECT_EQ(pixel(image, 12, kCy), kPureGreen);
  // 128 of 255 of the light, encoded.
  const double half = 1.055 * std::pow(128.0 / 255.0, 1 / 2.4) - 0.055;
  EXPECT_NEAR(pixel(image, 22, kCy).r, 255 * half, 1);
  marker.colors = {0xff804020};
  EXPECT_EQ(pixel(draw(marker), 12, kCy), glm::ivec3(0x20, 0x40, 0x80)) << "no tone mapping";
  marker.colors.clear();
  EXPECT_EQ(pixel(draw(marker), 12, kCy), glm::ivec3(255));
}

TEST_P(Markers, BoxIsSizedAndShaded) {
  const sinks::FrameImage image = draw(solid(MarkerKind::boxes, {0.4f, 0.2f, 0.4f}), at({-0.25f, 0, -1.2f}));
  // Front at 1 m: 40 x 20 pixels around (7, 24), of which 27 columns are in the image.
  // Seen under the angle atan(0.25): 0.3 + 0.7 cos of the light, encoded.
  EXPECT_NEAR(pixel(image, 7, kCy).r, 252.6, 3);
  EXPECT_GT(pixel(image, 26, kCy).r, 200);
  EXPECT_GT(pixel(image, 5, 15).r, 200);
  EXPECT_EQ(pixel(image, 5, 13), kBlack);
  EXPECT_EQ(pixel(image, 5, 35), kBlack);
  const glm::ivec3 side = pixel(image, 28, kCy);  // from x = 27 to 28.7: seen under a flat angle
  EXPECT_TRUE(side.r > 20 && side.r < 180) << side.r;
  EXPECT_EQ(pixel(image, 30, kCy), kBlack);
}

TEST_P(Markers, RoundSolidsHaveTheirSilhouette) {
  // A sphere of diameter 0.3 at 1 m: its silhouette has the radius 100 r / sqrt(1 - r^2).
  const sinks::FrameImage ball = draw(solid(MarkerKind::spheres, {0.3f, 0.3f, 0.3f}), at({0, 0, -1}));
  const auto count = [](const sinks::FrameImage& image) {
    int pixels = 0;
    for (uint32_t y = 0; y < kExtent.height; ++y)
      for (uint32_t x = 0; x < 33; ++x) pixels += pixel(image, x, y).r > 50 ? 1 : 0;
    return pixels;
  };
  // Half of it, the other half of the middle column, and pixels that it covers in part.
  EXPECT_NEAR(count(ball), std::numbers::pi / 2 * 100 * 100 * 0.0225 / 0.9775 + 15, 20);
  EXPECT_GT(pixel(ball, 17, kCy).r, 30);
  EXPECT_EQ(pixel(ball, 16, kCy), kBlack);
  // A cylinder along y, rotated from z: 0.2 wide, 0.3 long, at 1 m: 20 x 30 pixels and its curved ends.
  const glm::mat4 upright =
      at({0, 0, -1}) * glm::rotate(glm::mat4(1), std::numbers::pi_v<float> / 2, {1, 0, 0});
  const sinks::FrameImage cylinder = draw(solid(MarkerKind::cylinders, {0.2f, 0.2f, 0.3f}), upright);
  EXPECT_GT(pixel(cylinder, 24, kCy).r, 100);
  EXPECT_EQ(pixel(cylinder, 20, kCy), kBlack);
  EXPECT_GT(pixel(cylinder, 32, 10).r, 50);
  EXPECT_EQ(pixel(cylinder, 32, 5), kBlack);
  // A capsule is longer by its radius at both ends: to 0.25 m above the centre.
  const sinks::FrameImage capsule = draw(solid(MarkerKind::capsules, {0.2f, 0.2f, 0.2f}), upright);
  EXPECT_GT(pixel(capsule, 32, 6).r, 50);
  EXPECT_EQ(pixel(capsule, 32, 2), kBlack);
  EXPECT_EQ(pixel(capsule, 23, 7), kBlack) << "its end is round";
}

// Of a convex solid only back faces are hidden by front faces, so that culling alone shows the same image.
TEST_P(Markers, SolidsAreClosedAndFaceOutwards) {
  const glm::vec3 axis = glm::normalize(glm::vec3(1, 2, 3));
  const glm::mat4 turned = at({-0.1f, 0, -1}) * glm::rotate(glm::mat4(1), 0.9f, axis);
  for (const MarkerKind kind :
       {MarkerKind::boxes, MarkerKind::spheres, MarkerKind::cylinders, MarkerKind::capsules}) {
    for (const float mirror : {1.0f, -1.0f}) {
      const glm::mat4 world_from_marker = glm::scale(turned, glm::vec3(mirror, 1, 1));
      Marker marker = solid(kind, {0.2f, 0.15f, 0.1f});
      marker.rotations = {{0.5f, -0.5f, 0.5f, 0.5f}};
      const sinks::FrameImage tested = draw(marker, world_from_marker);
      EXPECT_GT(covered(tested, 0, 0, 0, 32, 49), 20) << marker_kind_name(kind);
      marker.flags = wire::kMarkerOverlaid;
      EXPECT_EQ(draw(marker, world_from_marker).rgba8, tested.rgba8)
          << marker_kind_name(kind) << (mirror < 0 ? " mirrored" : "");
    }
  }
}

TEST_P(Markers, ArrowSpansTailToTip) {
  const sinks::FrameImage image =
      draw(marker_of(MarkerKind::arrows, {{-0.3f, 0, -1}, {-0.1f, 0, -1}}, kRed, 4));
  const auto height = [&](uint32_t x) { return covered(image, 0, x, 0, x + 1, 49); };
  EXPECT_EQ(height(0), 0);
  EXPECT_GT(height(4), 1.5);
  EXPECT_LT(height(4), 4.5);
  EXPECT_GT(height(13), height(10) * 1.2) << "the head";
  EXPECT_GT(height(20), 0);
  EXPECT_EQ(height(23), 0);
}

TEST_P(Markers, AxesAreRedGreenAndBlue) {
  Marker marker = marker_of(MarkerKind::axes, {{-0.2f, 0, -1}}, kWhite, 3);
  marker.sizes = {{0.1f, 0.2f, 0.1f}};
  const sinks::FrameImage image = draw(marker);
  EXPECT_EQ(pixel(image, 18, kCy), kPureRed);
  EXPECT_EQ(pixel(image, 24, kCy), kBlack);
  EXPECT_EQ(pixel(image, 12, 8), kPureGreen);
  marker.rotations = {{0, 0.7071068f, 0, 0.7071068f}};  // z to x
  EXPECT_EQ(pixel(draw(marker), 18, kCy), glm::ivec3(0, 0, 255));
}

TEST_P(Markers, TrianglesAreSeenFromBothSides) {
  Marker marker =
      marker_of(MarkerKind::triangles, {{-0.3f, -0.2f, -1}, {-0.1f, -0.2f, -1}, {-0.2f, 0.2f, -1}}, kRed);
  const glm::ivec3 front = pixel(draw(marker), 12, 30);
  EXPECT_GT(front.r, 230);
  EXPECT_EQ(pixel(draw(marker), 3, 10), kBlack);
  std::swap(marker.positions[0], marker.positions[1]);
  EXPECT_EQ(pixel(draw(marker), 12, 30), front);
}

Marker text_of(const char* text, float size, uint32_t color = kRed) {
  Marker marker = marker_of(MarkerKind::texts, {{-0.1f, 0, -1}}, color, size);  // at the pixel (22, 24)
  marker.texts = {text};
  return marker;
}

// The outline of DejaVu Sans's I: a bar from x = 201 to 403 of its advance of 604, from y = 0 to 1493, of
// 2048 units per em. A line reaches from 1901 above the baseline to 483 below it.
TEST_P(Markers, TextHasOutlineOfItsFont) {
  const sinks::FrameImage image = draw(text_of("I", 40));
  // 3.9 x 29.2 pixels, from x = 20.0 to 24.0 and from y = 8.7 to 37.8.
  for (uint32_t y = 10; y <= 36; ++y)
    for (uint32_t x = 21; x <= 23; ++x) ASSERT_EQ(pixel(image, x, y), kPureRed) << x << " " << y;
  for (const glm::uvec2 at : {glm::uvec2(18, 24), glm::uvec2(26, 24), glm::uvec2(22, 6), glm::uvec2(22, 40)})
    EXPECT_EQ(pixel(image, at.x, at.y), kBlack) << at.x << " " << at.y;
  EXPECT_NEAR(covered(image, 0, 0, 0, 33, 49), 40.0 * 40 * 202 * 1493 / (2048.0 * 2048), 4);
  Marker in_metres = text_of("I", 0.4f);
  in_metres.width_unit = wire::MarkerUnit::lengths;
  EXPECT_NEAR(covered(draw(in_metres), 0, 0, 0, 33, 49), covered(image, 0, 0, 0, 33, 49), 0.5)
      << "0.4 m at 1 m";
  in_metres.positions = {{-0.2f, 0, -2}};
  EXPECT_NEAR(covered(draw(in_metres), 0, 0, 0, 33, 49), covered(image, 0, 0, 0, 33, 49) / 4, 2) << "at 2 m";
}

TEST_P(Markers, TextsHaveLinesAndColours) {
  const sinks::FrameImage lines = draw(text_of("I\nI", 20));
  // Bars from y = 4.7 to 19.3 and from 28.0 to 42.6.
  EXPECT_EQ(pixel(lines, 22, 12), kPureRed);
  EXPECT_EQ(pixel(lines, 22, 24), kBlack);
  EXPECT_EQ(pixel(lines, 22, 36), kPureRed);
  Marker two = text_of("I", 20);
  two.positions.push_back({0.05f, 0, -1});  // (37, 24)
  two.texts.push_back("III");
  two.colors = {kRed, kGreen};
  const sinks::FrameImage image = draw(two);
  EXPECT_EQ(pixel(image, 22, 24), kPureRed);
  EXPECT_EQ(pixel(image, 37, 24), kPureGreen);
  EXPECT_EQ(pixel(image, 37 - 6, 24).g > 120, true) << "604 of 2048 units apart: 5.9 pixels";
  const double bar = 20.0 * 20 * 202 * 1493 / (2048.0 * 2048);
  EXPECT_NEAR(covered(image, 0, 0, 0, 28, 49), bar, 2);
}

TEST_P(Markers, SurfacesHideTextsUnlessOverlaid) {
  Marker behind = text_of("I", 20);
  behind.positions = {{0.45f, 0, -3}};  // (47, 24)
  const glm::ivec3 grey = pixel(draw(behind), 47, kCy);
  EXPECT_TRUE(grey.r == grey.g && grey.r > 0) << "the block";
  behind.flags = wire::kMarkerOverlaid;
  EXPECT_EQ(pixel(draw(behind), 47, kCy), kPureRed);
}

TEST_P(Markers, MissingGlyphsAreBoxes) {
  const sinks::FrameImage box = draw(text_of("\xf4\x8f\xbf\xbd", 30));  // U+10FFFD
  EXPECT_GT(covered(box, 0, 0, 0, 33, 49), 20);
  EXPECT_EQ(draw(text_of("\xf3\xb0\x80\x80", 30)).rgba8, box.rgba8) << "U+F0000";
  EXPECT_NE(draw(text_of("\u00df", 30)).rgba8, box.rgba8) << "a sharp s";
  const sinks::FrameImage space = draw(text_of(" \n ", 30));
  shown_.clear();
  EXPECT_EQ(space.rgba8, draw().rgba8);
  // More different glyphs than the atlas holds.
  Marker all = text_of("", 8);
  for (char32_t c = 0x400; c < 0x2600; ++c) {
    if (c >= 0x2028 && c <= 0x202e) continue;
    std::string& text = all.texts.back();
    if (c < 0x800) {
      text += {static_cast<char>(0xc0 | c >> 6), static_cast<char>(0x80 | (c & 0x3f))};
    } else {
      text += {static_cast<char>(0xe0 | c >> 12), static_cast<char>(0x80 | (c >> 6 & 0x3f)),
               static_cast<char>(0x80 | (c & 0x3f))};
    }
  }
  EXPECT_GT(covered(draw(all), 0, 0, 0, 33, 49), 20);
  EXPECT_NEAR(covered(draw(text_of("I", 40)), 0, 0, 0, 33, 49), 40.0 * 40 * 202 * 1493 / (2048.0 * 2048), 4);
}

TEST_P(Markers, ImagesWithoutMarkersAreAsBefore) {
  const sinks::FrameImage before = bench_.draw(poses_, view());
  EXPECT_EQ(draw().rgba8, before.rgba8) << "requested, but there are none";
  show(marker_of(MarkerKind::points, {{-0.1f, 0, -1}}, kRed, 9));
  const sinks::FrameImage with = draw();
  EXPECT_NE(with.rgba8, before.rgba8);
  EXPECT_LE(largest_difference(with, before, 33), 1) << "the block";
  EXPECT_EQ(largest_difference(with, before, 48), 0) << "the block, outside of the markers' bounds";
  bench_.set_markers(nullptr);
  bench_.renderer().set_markers(shown_);
  EXPECT_EQ(bench_.draw(poses_, view()).rgba8, before.rgba8) << "not requested";
  if (GetParam() == settings::RasterPath::forward) return;
  const passes::ImageOutputs outputs(wire::kColorSrgb8 | wire::kDepthF32 | wire::kInstanceU32);
  const Taken taken = bench_.take(poses_, view(), outputs);
  EXPECT_EQ(taken.image.rgba8, before.rgba8);
}

TEST_P(Markers, OnlyNewValuesAreUploaded) {
  passes::SceneRenderer& renderer = bench_.renderer();
  show(marker_of(MarkerKind::points, std::vector<std::array<float, 3>>(10'000, {-0.1f, 0, -1}), kRed, 9));
  (void)draw();
  const uint64_t cloud = renderer.counts().uploaded_marker_bytes;
  EXPECT_GE(cloud, 120'000u);
  EXPECT_LT(cloud, 121'000u);
  shown_[0].world_from_marker = at({-0.1f, 0, 0});
  EXPECT_EQ(pixel(draw(), 12, kCy), kPureRed) << "its frame moves";
  EXPECT_EQ(renderer.counts().uploaded_marker_bytes, cloud);
  for (int i = 0; i < 100; ++i) {  // another marker changes with each image
    shown_.resize(1);
    const std::array<float, 3> place{0.01f * static_cast<float>(i % 10) - 0.3f, 0.1f, -1};
    show(marker_of(MarkerKind::points, std::vector(100, place), kGreen, 3));
    const sinks::FrameImage image = draw();
    EXPECT_EQ(pixel(image, 12, kCy), kPureRed) << i;
    EXPECT_EQ(pixel(image, 2 + static_cast<uint32_t>(i % 10), 14), kPureGreen) << i;
  }
  EXPECT_LT(renderer.counts().uploaded_marker_bytes, 3 * cloud + 100 * 1300) << "the cloud moves seldom";
}

}  // namespace
}  // namespace fire3dv::test
