// Test of lens models: undistortion inverts distortion, and the pinhole image behind a lens contains all
// visible points.
#include "renderer/passes/post/lens_pass.h"

#include <gtest/gtest.h>

#include <cmath>

namespace fire3dv::passes::test {
namespace {

struct Case {
  const char* name;
  Lens lens;
};
const Case kCases[] = {
    {"none", {}},
    {"barrel", {LensModel::plumb_bob, {-0.3f, 0.1f, 0.002f, -0.001f, -0.01f}}},
    {"pincushion", {LensModel::plumb_bob, {0.2f, 0.05f, -0.003f, 0.002f, 0}}},
    {"folding", {LensModel::plumb_bob, {-0.5f, 0, 0, 0, 0}}},
    {"fisheye", {LensModel::fisheye, {0.05f, -0.02f, 0.004f, -0.0005f, 0}}},
};

class Lenses : public ::testing::TestWithParam<Case> {};

TEST_P(Lenses, WhatTheyDoCanBeUndone) {
  const Lens& lens = GetParam().lens;
  const double largest = std::min(largest_radius(lens), 1.2);
  ASSERT_GT(largest, 0.5);
  int tried = 0;
  for (double r = 0; r < 0.95 * largest; r += 0.05, ++tried) {
    for (int i = 0; i < 12; ++i) {
      const glm::dvec2 point = r * glm::dvec2(std::cos(i * M_PI / 6), std::sin(i * M_PI / 6));
      const auto back = undistort(lens, distort(lens, point));
      ASSERT_TRUE(back) << r << " at " << i;
      EXPECT_LT(glm::distance(*back, point), 1e-6) << r << " at " << i;
    }
  }
  EXPECT_GT(tried, 9);
}

TEST_P(Lenses, PinholesHoldAllThatIsSeen) {
  const Lens& lens = GetParam().lens;
  const Intrinsics camera{310, 300, 330.5f, 220, {640, 480}, 0.1f, 0};
  const Result<Intrinsics> pinhole = pinhole_behind(camera, lens, 8192);
  ASSERT_TRUE(pinhole) << pinhole.error().message;
  size_t shown = 0;
  for (int y = 0; y < 480; y += 13) {
    for (int x = 0; x < 640; x += 13) {
      const auto point = undistort(lens, (glm::dvec2(x, y) - glm::dvec2(330.5, 220)) / glm::dvec2(310, 300));
      if (!point) continue;
      ++shown;
      const glm::dvec2 place =
          *point * glm::dvec2(pinhole->fx_px, pinhole->fy_px) + glm::dvec2(pinhole->cx_px, pinhole->cy_px);
      // Including a border of one pixel for bilinear filtering.
      ASSERT_TRUE(place.x >= 0 && place.y >= 0 && place.x <= pinhole->image_px.x - 2.0 &&
                  place.y <= pinhole->image_px.y - 2.0)
          << x << ", " << y << " at " << place.x << ", " << place.y;
    }
  }
  EXPECT_GT(shown, size_t{400});
  // Neighbouring image pixels are two pinhole pixels apart, or slightly more.
  const auto middle = undistort(lens, glm::dvec2(0)), beside = undistort(lens, glm::dvec2(1 / 310.0, 0));
  ASSERT_TRUE(middle && beside);
  EXPECT_GE((beside->x - middle->x) * pinhole->fx_px, 1.99);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Lenses, ::testing::ValuesIn(kCases),
                         [](const ::testing::TestParamInfo<Case>& of) { return of.param.name; });

TEST(Lens, FoldsAreWhereTheSlopeEnds) {
  const Lens folding{LensModel::plumb_bob, {-0.5f, 0, 0, 0, 0}};  // r - r^3 / 2
  EXPECT_NEAR(largest_radius(folding), std::sqrt(2.0 / 3), 0.01);
  EXPECT_FALSE(undistort(folding, {0.6, 0}));  // its maximum is 0.544
  EXPECT_TRUE(undistort(folding, {0.5, 0}));
}

TEST(Lens, WhatDoesNotFitIsSaid) {
  const Intrinsics wide{1400, 1400, 2000, 32, {4000, 64}, 0.1f, 0};
  const Result<Intrinsics> pinhole = pinhole_behind(wide, {LensModel::fisheye, {}}, 4096);
  ASSERT_FALSE(pinhole);
  EXPECT_NE(pinhole.error().message.find("too wide"), std::string::npos) << pinhole.error().message;
  for (const float absurd : {1e12f, -1e12f}) {
    for (const LensModel model : {LensModel::plumb_bob, LensModel::fisheye}) {
      const Lens lens{model, {absurd, -absurd, absurd, absurd, absurd}};
      const Result<Intrinsics> any = pinhole_behind({30, 30, 31.5f, 31.5f, {64, 64}, 0.1f, 0}, lens, 4096);
      EXPECT_TRUE(!any || (any->image_px.x <= 4096 && any->image_px.y <= 4096 && check(*any)));
    }
  }
}

}  // namespace
}  // namespace fire3dv::passes::test
