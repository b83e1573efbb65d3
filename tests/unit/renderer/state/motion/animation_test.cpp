// Test of animation samplers against the formulas of the glTF specification.
#include "renderer/state/motion/animation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace fire3dv::state {
namespace {

using scene::AnimationPath;
using scene::Interpolation;

struct Track {
  Track(AnimationPath path, Interpolation interpolation, uint32_t width, std::vector<float> times,
        std::vector<float> values) {
    channel.path = path;
    channel.interpolation = interpolation;
    channel.width = width;
    channel.key_count = static_cast<uint32_t>(times.size());
    // Not at the start of the arrays, so that offsets count.
    channel.first_time = 1;
    channel.first_value = 2;
    data.key_times_s = {-7};
    data.key_times_s.insert(data.key_times_s.end(), times.begin(), times.end());
    data.key_values = {-7, -7};
    data.key_values.insert(data.key_values.end(), values.begin(), values.end());
  }
  std::vector<float> at(double time_s) const {
    std::vector<float> value(channel.width);
    sample(data, channel, time_s, value);
    return value;
  }
  scene::Scene data;
  scene::AnimationChannel channel;
};

std::vector<float> about_z(double degrees) {
  const double half = degrees * 3.14159265358979323846 / 360;
  return {0, 0, static_cast<float>(std::sin(half)), static_cast<float>(std::cos(half))};
}

std::vector<float> joined(std::initializer_list<std::vector<float>> parts) {
  std::vector<float> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// A quaternion and its negative are the same rotation.
void expect_rotation(const std::vector<float>& value, const std::vector<float>& expected) {
  double dot = 0;
  for (size_t i = 0; i < 4; ++i) dot += double{value[i]} * double{expected[i]};
  EXPECT_NEAR(std::abs(dot), 1, 1e-6);
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(value[i], std::copysign(1.0, dot) * expected[i], 1e-6) << i;
}

TEST(AnimationSample, LinearIsHeldOutside) {
  const Track track(AnimationPath::translation, Interpolation::linear, 3, {1, 2, 4},
                    {0, 0, 0, 2, 4, 6, 6, 4, 2});
  EXPECT_EQ(track.at(-5), (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(track.at(1), (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(track.at(1.25), (std::vector<float>{0.5f, 1, 1.5f}));
  EXPECT_EQ(track.at(2), (std::vector<float>{2, 4, 6}));
  EXPECT_EQ(track.at(3), (std::vector<float>{4, 4, 4}));
  EXPECT_EQ(track.at(4), (std::vector<float>{6, 4, 2}));
  EXPECT_EQ(track.at(1e9), (std::vector<float>{6, 4, 2}));
}

TEST(AnimationSample, StepHoldsKey) {
  const Track track(AnimationPath::scale, Interpolation::step, 3, {0, 1, 2}, {1, 1, 1, 2, 2, 2, 3, 3, 3});
  EXPECT_EQ(track.at(0.999)[0], 1);
  EXPECT_EQ(track.at(1)[0], 2);
  EXPECT_EQ(track.at(1.999)[0], 2);
  EXPECT_EQ(track.at(2)[0], 3);
}

TEST(AnimationSample, OneKeyIsAConstant) {
  for (const Interpolation interpolation : {Interpolation::step, Interpolation::linear}) {
    const Track track(AnimationPath::translation, interpolation, 3, {3}, {1, 2, 3});
    for (const double time : {0.0, 3.0, 9.0}) EXPECT_EQ(track.at(time), (std::vector<float>{1, 2, 3}));
  }
  const Track spline(AnimationPath::translation, Interpolation::cubic_spline, 3, {3},
                     {9, 9, 9, 1, 2, 3, 9, 9, 9});
  for (const double time : {0.0, 3.0, 9.0}) EXPECT_EQ(spline.at(time), (std::vector<float>{1, 2, 3}));
}

TEST(AnimationSample, RotationsTurnAtConstantRate) {
  const Track track(AnimationPath::rotation, Interpolation::linear, 4, {0, 3},
                    joined({about_z(0), about_z(120)}));
  for (const double time : {0.0, 0.5, 1.0, 2.0, 2.75}) expect_rotation(track.at(time), about_z(40 * time));
}

TEST(AnimationSample, RotationsTakeTheShorterWay) {
  std::vector<float> other_sign = about_z(90);
  for (float& part : other_sign) part = -part;
  const Track track(AnimationPath::rotation, Interpolation::linear, 4, {0, 1},
                    joined({about_z(0), other_sign}));
  expect_rotation(track.at(1.0 / 3), about_z(30));
}

TEST(AnimationSample, NearlyEqualRotationsStayUnit) {
  const Track track(AnimationPath::rotation, Interpolation::linear, 4, {0, 1},
                    joined({about_z(10), about_z(10.001)}));
  const std::vector<float> value = track.at(0.5);
  expect_rotation(value, about_z(10.0005));
  const Track same(AnimationPath::rotation, Interpolation::linear, 4, {0, 1},
                   joined({about_z(10), about_z(10)}));
  expect_rotation(same.at(0.5), about_z(10));
}

// Reference by de Casteljau's algorithm: the control points are the values, and the values plus a third of
// the tangents, which are per second.
double de_casteljau(double from, double out, double in, double to, double seconds, double t) {
  std::array<double, 4> p{from, from + seconds * out / 3, to - seconds * in / 3, to};
  for (size_t left = 3; left > 0; --left) {
    for (size_t i = 0; i < left; ++i) p[i] += (p[i + 1] - p[i]) * t;
  }
  return p[0];
}

TEST(AnimationSample, SplineTangentsScaleByTime) {
  // In-tangent, value, out-tangent at 1 s, 3 s and 3.5 s.
  const std::vector<float> values{7, 1, 2, -3, 5, 4, 1, -2, 8};
  const Track track(AnimationPath::weights, Interpolation::cubic_spline, 1, {1, 3, 3.5f}, values);
  EXPECT_EQ(track.at(0)[0], 1);
  EXPECT_EQ(track.at(3)[0], 5);
  EXPECT_EQ(track.at(9)[0], -2);
  for (const double t : {0.1, 0.25, 0.5, 0.9}) {
    EXPECT_NEAR(track.at(1 + 2 * t)[0], de_casteljau(1, 2, -3, 5, 2, t), 1e-5) << t;
    EXPECT_NEAR(track.at(3 + 0.5 * t)[0], de_casteljau(5, 4, 1, -2, 0.5, t), 1e-5) << t;
  }
  // The slope at a key equals its tangent.
  const double step = 1e-3;
  EXPECT_NEAR((track.at(1 + step)[0] - track.at(1)[0]) / step, 2, 2e-2);
  EXPECT_NEAR((track.at(3)[0] - track.at(3 - step)[0]) / step, -3, 2e-2);
}

TEST(AnimationSample, SplinesOfRotationsAreNormalised) {
  const std::vector<float> still{0, 0, 0, 0};
  const Track track(AnimationPath::rotation, Interpolation::cubic_spline, 4, {0, 1},
                    joined({still, about_z(0), still, still, about_z(90), still}));
  expect_rotation(track.at(0.5), about_z(45));
  // An interpolation through zero: any unit rotation is valid.
  const Track through(AnimationPath::rotation, Interpolation::cubic_spline, 4, {0, 1},
                      joined({still, {1, 0, 0, 0}, still, still, {-1, 0, 0, 0}, still}));
  expect_rotation(through.at(0.5), {0, 0, 0, 1});
}

TEST(AnimationSample, WeightsOfAllTargetsTogether) {
  const Track track(AnimationPath::weights, Interpolation::linear, 2, {0, 2}, {0, 1, 1, 0.5f});
  EXPECT_EQ(track.at(1), (std::vector<float>{0.5f, 0.75f}));
}

}  // namespace
}  // namespace fire3dv::state
