// Test of the sun of environment images: where it is, how bright and how wide; that light and rest together
// have the irradiance of the image; and images without a sun.
#include "renderer/scene/textures/environment_sun.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>

namespace fire3dv::scene {
namespace {

using Sky = std::function<glm::dvec3(const glm::vec3& direction)>;

struct Disc {
  glm::vec3 to_center;
  double radius_rad;
  glm::dvec3 radiance;
};

glm::dvec3 blue_sky(const glm::vec3& direction) {
  if (direction.y < 0) return glm::dvec3(0.075, 0.06, 0.045);
  return glm::dvec3(0.08, 0.14, 0.3) * (1.5 - static_cast<double>(direction.y));
}

// Texels have the share of the disc that covers them.
EnvironmentImage sky_with_disc(uint32_t width, const Disc& disc, const Sky& sky = blue_sky) {
  EnvironmentImage image;
  image.width = width;
  image.height = width / 2;
  constexpr int kSteps = 12;  // along a texel near the disc
  const double texel_rad = 2 * std::numbers::pi / width, least = std::cos(disc.radius_rad);
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const auto direction = [&](double dx, double dy) {
        return environment_direction(static_cast<float>((x + dx) / image.width),
                                     static_cast<float>((y + dy) / image.height));
      };
      double covered = 0;
      if (glm::dot(direction(0.5, 0.5), disc.to_center) > std::cos(disc.radius_rad + 2 * texel_rad)) {
        double area = 0;
        for (int i = 0; i < kSteps * kSteps; ++i) {
          const double dx = (i % kSteps + 0.5) / kSteps, dy = (i / kSteps + 0.5) / kSteps;
          const double weight = std::sin((y + dy) / image.height * std::numbers::pi);
          const bool is_inside = static_cast<double>(glm::dot(direction(dx, dy), disc.to_center)) > least;
          area += weight;
          covered += is_inside ? weight : 0;
        }
        covered /= area;
      }
      image.rgb9e5.push_back(pack_rgb9e5(glm::vec3(sky(direction(0.5, 0.5)) + covered * disc.radiance)));
    }
  }
  return image;
}

glm::dvec3 irradiance(const EnvironmentImage& image, const glm::vec3& normal) {
  glm::dvec3 sum(0);
  const double tall = std::numbers::pi / image.height;
  for (uint32_t y = 0; y < image.height; ++y) {
    const double solid_angle =
        2 * std::numbers::pi / image.width * (std::cos(y * tall) - std::cos((y + 1) * tall));
    for (uint32_t x = 0; x < image.width; ++x) {
      const glm::vec3 direction =
          environment_direction((static_cast<float>(x) + 0.5f) / static_cast<float>(image.width),
                                (static_cast<float>(y) + 0.5f) / static_cast<float>(image.height));
      const double cosine = static_cast<double>(glm::dot(direction, normal));
      if (cosine > 0)
        sum += solid_angle * cosine * glm::dvec3(unpack_rgb9e5(image.rgb9e5[size_t{y} * image.width + x]));
    }
  }
  return sum * static_cast<double>(image.scale);
}

double degrees_between(const glm::vec3& a, const glm::vec3& b) {
  const glm::dvec3 cross = glm::cross(glm::dvec3(a), glm::dvec3(b));
  return std::atan2(glm::length(cross), glm::dot(glm::dvec3(a), glm::dvec3(b))) * 180 / std::numbers::pi;
}

glm::vec3 towards(double azimuth_deg, double elevation_deg) {
  const double a = azimuth_deg * std::numbers::pi / 180, e = elevation_deg * std::numbers::pi / 180;
  return glm::vec3(glm::dvec3(std::cos(e) * std::sin(a), std::sin(e), -std::cos(e) * std::cos(a)));
}

const glm::dvec3 kWarm(5000, 4500, 3500);

// Everywhere, the seam behind the camera (180 degrees), both poles and the horizon included.
TEST(EnvironmentSun, DirectionColourAndSizeAreThoseOfTheDisc) {
  struct Case {
    double azimuth_deg, elevation_deg, radius_deg;
    uint32_t width;
  };
  for (const Case& at : {Case{40, 45, 1, 512},
                         {180, 30, 1.5, 256},
                         {179.6, 30, 0.8, 512},
                         {-120, 0, 1, 512},
                         {0, 90, 1, 512},
                         {30, 89.5, 1.2, 512},
                         {10, -90, 1, 512},
                         {75, 60, 0.27, 1024}}) {
    SCOPED_TRACE(std::to_string(at.azimuth_deg) + " " + std::to_string(at.elevation_deg));
    const double radius_rad = at.radius_deg * std::numbers::pi / 180;
    const Disc disc{towards(at.azimuth_deg, at.elevation_deg), radius_rad, kWarm};
    const EnvironmentImage image = sky_with_disc(at.width, disc);
    const auto split = split_sun(image);
    ASSERT_TRUE(split);
    EXPECT_LT(degrees_between(split->sun.to_sun, disc.to_center), 0.1);
    const double solid_angle = 2 * std::numbers::pi * (1 - std::cos(radius_rad));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(split->sun.illuminance_lux[c] / (solid_angle * kWarm[c]), 1, 0.03);
    // Bilinear filtering of texels widens it.
    const double texel = 2 * std::numbers::pi / at.width;
    EXPECT_GT(split->sun.angular_radius_rad, 0.95 * radius_rad);
    EXPECT_LT(split->sun.angular_radius_rad, std::sqrt(radius_rad * radius_rad + texel * texel) * 1.05);
  }
}

TEST(EnvironmentSun, LightAndRestHaveTheIrradianceOfTheImage) {
  for (const double elevation_deg : {12.0, 50.0, 90.0}) {
    const EnvironmentImage image = sky_with_disc(256, {towards(25, elevation_deg), 0.02, kWarm});
    const auto split = split_sun(image);
    ASSERT_TRUE(split);
    for (const glm::vec3 normal : {glm::vec3(0, 1, 0), towards(25, 30), towards(-50, 20), towards(100, 60)}) {
      const glm::dvec3 whole = irradiance(image, normal);
      const double cosine = std::max(static_cast<double>(glm::dot(normal, split->sun.to_sun)), 0.0);
      const glm::dvec3 both =
          irradiance(split->rest, normal) + cosine * glm::dvec3(split->sun.illuminance_lux);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(both[c] / whole[c], 1, 0.002);
    }
    // Nothing of the disc is left.
    float most = 0;
    for (const uint32_t texel : split->rest.rgb9e5) most = std::max(most, unpack_rgb9e5(texel).r);
    EXPECT_LT(most, 0.5f);
    const double facing = irradiance(image, split->sun.to_sun).g;
    EXPECT_NEAR(split->sun.share_of_illuminance, static_cast<double>(split->sun.illuminance_lux.g) / facing,
                0.02);
  }
}

TEST(EnvironmentSun, ScaleOfBrightImagesCounts) {
  EnvironmentImage image = sky_with_disc(256, {towards(0, 40), 0.02, kWarm});
  const auto once = split_sun(image);
  image.scale = 16;
  const auto scaled = split_sun(image);
  ASSERT_TRUE(once && scaled);
  EXPECT_FLOAT_EQ(scaled->sun.illuminance_lux.r, 16 * once->sun.illuminance_lux.r);
  EXPECT_FLOAT_EQ(scaled->sun.share_of_illuminance, once->sun.share_of_illuminance);
  EXPECT_EQ(scaled->rest.scale, 16);
}

// A second, weaker sun stays in the image.
TEST(EnvironmentSun, BrightestOfTwoIsTheLight) {
  const Disc strong{towards(-60, 50), 0.02, kWarm}, weak{towards(90, 40), 0.02, 0.5 * kWarm};
  const EnvironmentImage image = sky_with_disc(256, strong, [&](const glm::vec3& direction) {
    const bool is_inside = degrees_between(direction, weak.to_center) < 1.1;
    return blue_sky(direction) + (is_inside ? weak.radiance : glm::dvec3(0));
  });
  const auto split = split_sun(image);
  ASSERT_TRUE(split);
  EXPECT_LT(degrees_between(split->sun.to_sun, strong.to_center), 0.1);
  EXPECT_GT(irradiance(split->rest, weak.to_center).r, 1);
}

// The glow around a sun is not a part of it.
TEST(EnvironmentSun, GlowStaysInTheImage) {
  const Disc disc{towards(20, 35), 0.01, kWarm};
  const EnvironmentImage image = sky_with_disc(512, disc, [&](const glm::vec3& direction) {
    return blue_sky(direction) + 6.0 * std::exp(-degrees_between(direction, disc.to_center) / 6);
  });
  const auto split = split_sun(image);
  ASSERT_TRUE(split);
  EXPECT_LT(degrees_between(split->sun.to_sun, disc.to_center), 0.1);
  EXPECT_LT(split->sun.angular_radius_rad, 0.02f);
}

TEST(EnvironmentSun, TurnsWithTheEnvironment) {
  EnvironmentSun sun;
  sun.to_sun = {0, 0, -1};
  const glm::vec3 turned = world_direction(sun, static_cast<float>(std::numbers::pi / 2));  // seen from above
  EXPECT_NEAR(turned.x, -1, 1e-6);
  EXPECT_NEAR(turned.z, 0, 1e-6);
}

TEST(EnvironmentSun, ImagesWithoutSunHaveNone) {
  const Disc none{{0, 1, 0}, 0.01, glm::dvec3(0)};
  const glm::vec3 zenith(0, 1, 0), side = towards(60, 20);
  const std::pair<const char*, Sky> skies[] = {
      {"black", [](const glm::vec3&) { return glm::dvec3(0); }},
      {"uniform", [](const glm::vec3&) { return glm::dvec3(1); }},
      {"clear sky without a sun", blue_sky},
      // CIE overcast sky: three times as bright overhead as at the horizon.
      {"overcast", [](const glm::vec3& d) { return glm::dvec3(d.y > 0 ? (1 + 2 * d.y) / 3 : 0.1); }},
      // Clipped at the white of a display.
      {"clipped", [&](const glm::vec3& d) { return glm::dvec3(degrees_between(d, side) < 1.5 ? 1 : 0.4); }},
      {"softbox", [&](const glm::vec3& d) { return glm::dvec3(degrees_between(d, side) < 12 ? 50 : 0.1); }},
      {"tube",
       [&](const glm::vec3& d) { return glm::dvec3(std::abs(d.x) < 0.02f && d.y > 0.5f ? 200 : 0.1); }},
      {"star", [&](const glm::vec3& d) { return glm::dvec3(degrees_between(d, zenith) < 0.8 ? 20 : 0.5); }},
  };
  for (const auto& [name, sky] : skies) EXPECT_FALSE(split_sun(sky_with_disc(256, none, sky))) << name;
  EXPECT_FALSE(split_sun(studio_environment()));
  EXPECT_FALSE(split_sun(sky_with_disc(16, {side, 0.02, kWarm}))) << "texels larger than a sun";
  EXPECT_FALSE(split_sun(EnvironmentImage{1, 1, {pack_rgb9e5(glm::vec3(1))}, 1}));
}

TEST(EnvironmentSun, SameImageGivesSameSplit) {
  const EnvironmentImage image = sky_with_disc(256, {towards(0, 50), 0.02, kWarm});
  const auto a = split_sun(image), b = split_sun(image);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->rest.rgb9e5, b->rest.rgb9e5);
  EXPECT_EQ(a->sun.to_sun, b->sun.to_sun);
  EXPECT_EQ(a->sun.illuminance_lux, b->sun.illuminance_lux);
  EXPECT_EQ(a->sun.angular_radius_rad, b->sun.angular_radius_rad);
}

}  // namespace
}  // namespace fire3dv::scene
