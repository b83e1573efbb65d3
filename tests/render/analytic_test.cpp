// Render tests against closed-form radiometry and geometry: the expected pixels follow from formulas.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/packing.hpp>

#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr float kPi = 3.14159265f;

settings::DrawSettings no_ambient() {
  settings::DrawSettings settings;
  settings.environment_intensity = 0;
  return settings;
}

// Inverts the sRGB curve and Reinhard's operator: the radiance of an 8-bit pixel before tone mapping.
float light_of(int channel) {
  const float encoded = static_cast<float>(channel) / 255.0f;
  const float display = encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
  return display / (1 - display);
}

// Reflectance of a dielectric of roughness 1 and index 1.5 (docs/design/materials.md), by quadrature. At
// roughness 1 the distribution is 1 / pi everywhere, and the roots of the shadowing term are 1.
class RoughDielectric {
 public:
  RoughDielectric() {
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = (i + 0.5) / kSteps;
      mean_loss_ += 2 * cosine / kSteps * loss(cosine);
    }
    const double mean_fresnel = 0.04 + 0.96 / 21;
    multiple_ = mean_fresnel * mean_fresnel * (1 - mean_loss_) / (1 - mean_fresnel * mean_loss_);
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = (i + 0.5) / kSteps;
      mean_entering_ += 2 * cosine / kSteps * (1 - albedo(cosine));
    }
  }

  double brdf(double n_dot_l, double n_dot_v, double v_dot_h, double diffuse) const {
    const double specular = fresnel(v_dot_h) / kPi * 0.5 / (n_dot_l + n_dot_v);
    const double multiple = multiple_ * loss(n_dot_v) * loss(n_dot_l) / (kPi * mean_loss_);
    const double below = diffuse * (1 - albedo(n_dot_v)) * (1 - albedo(n_dot_l)) / (kPi * mean_entering_);
    return specular + multiple + below;
  }

 private:
  static constexpr int kSteps = 64;
  static double fresnel(double v_dot_h) { return 0.04 + 0.96 * std::pow(1 - v_dot_h, 5); }
  // Share of white facets' light that takes more than one bounce: the integral of 1 - m / (m + n_dot_v).
  static double loss(double n_dot_v) { return n_dot_v * std::log((1 + n_dot_v) / n_dot_v); }
  double albedo(double n_dot_v) const {
    const glm::dvec3 v(std::sqrt(1 - n_dot_v * n_dot_v), 0, n_dot_v);
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      for (int k = 0; k < kSteps; ++k) {
        const double z = (i + 0.5) / kSteps, angle = 2 * kPi * (k + 0.5) / kSteps, s = std::sqrt(1 - z * z);
        const glm::dvec3 l(s * std::cos(angle), s * std::sin(angle), z);
        sum += fresnel(glm::dot(v, glm::normalize(v + l))) * z / (z + n_dot_v);
      }
    }
    return sum / (kSteps * kSteps) + multiple_ * loss(n_dot_v);
  }

  double mean_loss_ = 0, multiple_ = 0, mean_entering_ = 0;
};

class Analytic : public ValidationIsSilent {};

// A rough dielectric under one light, against the material model by quadrature in double precision.
TEST_F(Analytic, LambertSphereUnderOneLight) {
  SceneBuilder builder;
  const float albedo = 0.6f, lux = 2.0f;
  const glm::vec3 to_light = glm::normalize(glm::vec3(0.5f, 0.7f, 0.6f));
  builder.mesh_node("ball", builder.sphere(builder.material(matte(glm::vec3(albedo))), 1, 256), glm::mat4(1));
  builder.light_node(sun({1, 1, 1}, lux), shining_towards(-to_light));
  builder.camera_node("camera", {0, 0, 100}, {0, 0, 0}, 2 * std::atan(1.2f / 100));  // nearly orthographic
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, {200, 200}, no_ambient());
  const sinks::FrameImage image = bench.draw_at_rest();

  const RoughDielectric model;
  int compared = 0;
  for (uint32_t y = 10; y < 190; y += 6) {
    for (uint32_t x = 10; x < 190; x += 6) {
      const float px = ((static_cast<float>(x) + 0.5f) / 100 - 1) * 1.2f;
      const float py = (1 - (static_cast<float>(y) + 0.5f) / 100) * 1.2f;
      const float r2 = px * px + py * py;
      if (r2 > 0.9f) continue;
      const glm::vec3 n(px, py, std::sqrt(1 - r2));
      const float n_dot_l = glm::dot(n, to_light);
      if (n_dot_l < 0.1f) continue;
      const glm::vec3 v(0, 0, 1), h = glm::normalize(to_light + v);
      const auto expected =
          static_cast<float>(model.brdf(n_dot_l, n.z, glm::dot(v, h), albedo) * n_dot_l * lux);
      const float seen = light_of(pixel(image, x, y).r);
      ASSERT_NEAR(seen, expected, 0.004f + 0.01f * expected) << "at " << x << ", " << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, 300);
}

// A square above the ground under a vertical directional light: its shadow is its own outline.
TEST_F(Analytic, ShadowEdgesFollowGeometry) {
  SceneBuilder builder;
  builder.mesh_node("ground", builder.quad(builder.material(matte({0.8f, 0.8f, 0.8f})), 10), glm::mat4(1));
  builder.mesh_node("lid", builder.box(builder.material(matte({0.8f, 0, 0})), {0.5f, 0.01f, 0.5f}),
                    at({0, 30, 0}));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({0, -1, 0}));
  builder.camera_node("camera", {0, 10, 0}, {0, 0, 0}, 2 * std::atan(0.1f));  // below the lid; sees 2 m x 2 m
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, {200, 200}, no_ambient());
  const sinks::FrameImage image = bench.draw_at_rest();

  for (uint32_t y = 0; y < 200; ++y) {
    for (uint32_t x = 0; x < 200; ++x) {
      const float px = std::abs((static_cast<float>(x) + 0.5f) / 100 - 1);
      const float py = std::abs((static_cast<float>(y) + 0.5f) / 100 - 1);
      const float outside_m = std::max(px, py) - 0.5f;
      if (std::abs(outside_m) < 0.011f) continue;  // skips pixels that the edge crosses
      if (outside_m < 0) {
        ASSERT_EQ(pixel(image, x, y), glm::ivec3(0)) << "lit in the shadow at " << x << ", " << y;
      } else {
        ASSERT_GT(pixel(image, x, y).r, 100) << "dark outside the shadow at " << x << ", " << y;
      }
    }
  }
}

// Shadows are independent of the scale, without acne: equal images at scales 250,000 times apart.
TEST_F(Analytic, ShadowsScaleWithTheScene) {
  std::vector<sinks::FrameImage> images;
  for (const float scale : {0.002f, 1.0f, 500.0f}) {
    SceneBuilder builder;
    builder.mesh_node("ground", builder.quad(builder.material(matte({0.8f, 0.8f, 0.8f})), 3 * scale),
                      glm::mat4(1));
    builder.mesh_node("ball", builder.sphere(builder.material(matte({0.8f, 0.3f, 0.3f})), scale, 64),
                      at({0, scale, 0}));
    builder.light_node(sun({1, 1, 1}, 3), shining_towards({-1, -1, -0.5f}));
    builder.camera_node("camera", glm::vec3(0, 3, 6) * scale, glm::vec3(0, 0.5f, 0) * scale);
    scene::Scene scene = builder.build();
    scene.cameras[0].near_m = 0.01f * scale;
    RenderBench bench(scene, {160, 120}, no_ambient());
    images.push_back(bench.draw_at_rest());
  }
  for (size_t i : {0u, 2u}) {
    uint64_t different = 0;
    for (size_t byte = 0; byte < images[1].rgba8.size(); ++byte) {
      different += std::abs(images[i].rgba8[byte] - images[1].rgba8[byte]) > 8;
    }
    EXPECT_LT(different, images[1].rgba8.size() / 500);
  }
}

// An unlit surface shows its colour. Linear images have the nearest half float.
TEST_F(Analytic, LinearImagesRoundToNearestHalf) {
  constexpr float kStep = 1.0f / 4096;  // between halves from 0.25 to 0.5
  const glm::vec3 color(1366.75f * kStep, 1366.25f * kStep, 1366.5f * kStep);  // the last is a tie: to even
  const glm::vec3 nearest(1367 * kStep, 1366 * kStep, 1366 * kStep);
  scene::Material material = matte(color);
  material.unlit = true;
  SceneBuilder builder;
  builder.mesh_node("wall", builder.quad(builder.material(material), 10), glm::mat4(1));
  builder.camera_node("camera", {0, 5, 0}, {0, 0, 0}, 0.2f);
  const scene::Scene scene = builder.build();
  const state::PoseState poses(scene);
  for (const uint32_t samples : {1u, 4u}) {
    settings::DrawSettings settings = no_ambient();
    settings.samples = samples;
    RenderBench bench(scene, {8, 8}, settings);
    passes::ImageOutputs outputs;
    outputs.add(wire::kColorLinearF16);
    const Taken taken = bench.take(poses, first_camera_view(scene, poses, {8, 8}), outputs);
    for (const uint64_t texel : taken.plane<uint64_t>(wire::kColorLinearF16)) {
      const glm::vec3 seen(glm::unpackHalf4x16(texel));
      EXPECT_EQ(seen, nearest) << samples << " samples: " << seen.x << " " << seen.y << " " << seen.z;
    }
  }
}

// A point light's irradiance falls with the square of the distance.
TEST_F(Analytic, PointLightFallsWithTheSquare) {
  for (const float height : {1.0f, 2.0f, 4.0f}) {
    SceneBuilder builder;
    const float albedo = 0.5f, candela = 10;
    builder.mesh_node("ground", builder.quad(builder.material(matte(glm::vec3(albedo))), 10), glm::mat4(1));
    scene::Light light;
    light.type = scene::LightType::point;
    light.intensity = candela;
    builder.light_node(light, at({0, height, 0}));
    builder.camera_node("camera", {0, 20, 0.001f}, {0, 0, 0}, 0.05f);
    const scene::Scene scene = builder.build();
    RenderBench bench(scene, {33, 33}, no_ambient());
    const float seen = light_of(pixel(bench.draw_at_rest(), 16, 16).r);
    const auto expected =
        static_cast<float>(RoughDielectric().brdf(1, 1, 1, albedo) * candela / (height * height));
    EXPECT_NEAR(seen, expected, 0.02f * expected + 0.005f) << "at " << height << " m";
  }
}

// Exposure scales radiance before tone mapping.
TEST_F(Analytic, ExposureScalesLight) {
  SceneBuilder builder;
  scene::Material material = matte({0, 0, 0});
  material.emissive = glm::vec3(0.25f);
  builder.mesh_node("wall", builder.quad(builder.material(material), 10), glm::mat4(1));
  builder.camera_node("camera", {0, 5, 0}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  for (const float exposure : {0.5f, 1.0f, 2.0f}) {
    settings::DrawSettings settings;
    settings.environment_intensity = 0;
    settings.post.exposure = exposure;
    RenderBench bench(scene, {16, 16}, settings);
    EXPECT_NEAR(light_of(pixel(bench.draw_at_rest(), 8, 8).g), 0.25f * exposure, 0.01f);
  }
}

}  // namespace
}  // namespace fire3dv::test
