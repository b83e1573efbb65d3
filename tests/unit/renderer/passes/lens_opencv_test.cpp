// Test of lens distortion against OpenCV. The table comes from OpenCV 4.6.0 (Debian 12's
// libopencv-calib3d-dev) with kPoints in metres, times 2.5, before a camera at the origin without rotation:
//   cv::projectPoints(points, zero, zero, K, coefficients, pixels);
//   cv::fisheye::projectPoints(points, pixels, zero, zero, K, coefficients);
#include <gtest/gtest.h>

#include "renderer/passes/post/lens_pass.h"

namespace fire3dv::passes::test {
namespace {

constexpr double kFx = 620.5, kFy = 615.75, kCx = 318.25, kCy = 241.5;  // K
const glm::dvec2 kPoints[] = {{0, 0},       {0.1, 0.05}, {-0.25, 0.3}, {0.4, -0.35},
                              {-0.5, -0.2}, {0.6, 0.45}, {0, 0.7},     {-0.75, 0.1}};

const struct {
  Lens lens;
  glm::dvec2 pixels[std::size(kPoints)];
} kByOpenCv[] = {
    {{LensModel::plumb_bob, {-0.3f, 0.1f, 0.002f, -0.001f, -0.01f}},
     {{318.250000000, 241.500000000},
      {380.060524560, 272.187921075},
      {169.508369311, 418.698716856},
      {546.618551686, 43.402874783},
      {32.216220393, 128.390898979},
      {638.715912112, 480.962019410},
      {317.945954986, 620.816441382},
      {-82.816014355, 295.224139152}}},
    {{LensModel::plumb_bob, {0.2f, 0.05f, -0.003f, 0.002f, 0}},
     {{318.250000000, 241.500000000},
      {380.477327270, 272.344697404},
      {158.836908657, 431.274977487},
      {582.732618326, 11.631836933},
      {-10.691011494, 110.252271642},
      {738.910025622, 553.021250761},
      {318.858090029, 717.224448308},
      {-205.651094047, 309.855196531}}},
    {{LensModel::plumb_bob, {-0.28f, 0.07f, 0, 0, 0}},
     {{318.250000000, 241.500000000},
      {380.083503671, 272.180080488},
      {169.496303722, 418.637963222},
      {548.203933710, 41.830591706},
      {31.365858349, 127.624795989},
      {640.158613067, 481.083273766},
      {318.250000000, 620.632606954},
      {-83.202456767, 294.617238841}}},
    {{LensModel::fisheye, {0.05f, -0.02f, 0.004f, -0.0005f, 0}},
     {{318.250000000, 241.500000000},
      {380.081492866, 272.179082782},
      {169.389635675, 418.764985012},
      {548.857390902, 41.263193667},
      {30.506624222, 127.283733354},
      {643.288270745, 483.412548603},
      {318.250000000, 623.595759422},
      {-87.210635166, 295.147571551}}},
    {{LensModel::fisheye, {-0.03f, 0.01f, -0.002f, 0.0001f, 0}},
     {{318.250000000, 241.500000000},
      {380.020493734, 272.148816694},
      {170.946632523, 416.910891586},
      {544.873264486, 44.722617697},
      {35.578171276, 129.296822861},
      {634.219003621, 476.662667985},
      {318.250000000, 613.831481845},
      {-75.773338470, 293.634272503}}},
};

TEST(Lens, PointsMatchOpenCv) {
  for (size_t number = 0; number < std::size(kByOpenCv); ++number) {
    const auto& [lens, pixels] = kByOpenCv[number];
    for (size_t i = 0; i < std::size(kPoints); ++i) {
      const glm::dvec2 pixel = distort(lens, kPoints[i]) * glm::dvec2(kFx, kFy) + glm::dvec2(kCx, kCy);
      EXPECT_LT(glm::distance(pixel, pixels[i]), 1e-6) << "lens " << number << ", point " << i;
      const auto back = undistort(lens, (pixels[i] - glm::dvec2(kCx, kCy)) / glm::dvec2(kFx, kFy));
      ASSERT_TRUE(back) << i;
      EXPECT_LT(glm::distance(*back, kPoints[i]), 1e-6) << i;
    }
  }
}

}  // namespace
}  // namespace fire3dv::passes::test
