// Render test of an endoscope's camera: condensation, lateral colour, vignette, sensor noise, response and
// content mask, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "renderer/passes/post/lens_pass.h"
#include "renderer/passes/post/sensor_pass.h"
#include "renderer/settings/setting_table.h"
#include "tests/render/support/proof_bench.h"
#include "tests/render/support/walls.h"

namespace fire3dv::test {
namespace {

class Sensor : public ValidationIsSilent {};

scene::Material glowing(glm::vec3 radiance) {
  scene::Material material = matte({0, 0, 0});
  material.specular = 0;
  material.emissive = radiance;
  return material;
}

// A linear sensor: bytes are proportional to light.
settings::DrawSettings linear_sensor() {
  settings::DrawSettings settings = plain_settings();
  settings.environment_intensity = 0;
  settings.background.color = glm::vec3(0);
  settings.post.optics.response = 1;
  return settings;
}

TEST_F(Sensor, VignetteIsAPowerOfTheCosine) {
  constexpr VkExtent2D kSize{64, 48};
  for (const uint32_t samples : {1u, 4u}) {
    settings::DrawSettings settings = linear_sensor();
    settings.samples = samples;
    settings.post.optics.vignette = 4;
    const sinks::FrameImage image = drawn(wall(glowing(glm::vec3(0.98f)), 0.05f, 1.2f), settings, kSize);
    for (const glm::uvec2 at :
         {glm::uvec2(0, 0), glm::uvec2(10, 40), glm::uvec2(31, 23), glm::uvec2(63, 47)}) {
      const glm::dvec3 point = glm::normalize(point_at(at, kSize, 0.05, 1.2));
      EXPECT_NEAR(pixel(image, at.x, at.y).g, 255 * 0.98 * std::pow(-point.z, 4), 1.5) << at.x;
    }
  }
}

TEST_F(Sensor, ResponseIsAPower) {
  settings::DrawSettings settings = linear_sensor();
  settings.post.optics.response = 2.2f;
  settings.post.exposure = 2;
  const sinks::FrameImage image = drawn(wall(glowing({0.05f, 0.2f, 3})), settings, {16, 12});
  EXPECT_NEAR(pixel(image, 8, 6).r, 255 * std::pow(0.1, 1 / 2.2), 1);
  EXPECT_NEAR(pixel(image, 8, 6).g, 255 * std::pow(0.4, 1 / 2.2), 1);
  EXPECT_EQ(pixel(image, 8, 6).b, 255);
}

TEST_F(Sensor, MaskEmptiesColorsAndPlanes) {
  constexpr VkExtent2D kSize{64, 48};
  const scene::Scene scene = wall(glowing(glm::vec3(0.5f)), 2);
  const state::PoseState poses(scene);
  const passes::View view = first_camera_view(scene, poses, kSize);
  passes::ImageOutputs outputs = wire::ImageOutputs::all_planes();
  outputs.remove(wire::kMotion);
  outputs.remove(wire::kOcclusionU32);
  outputs.remove(wire::kAmodal);
  outputs.add(wire::kColorSrgb8);
  settings::DrawSettings settings = linear_sensor();
  const Taken whole = RenderBench(scene, kSize, settings).take(poses, view, outputs);
  settings.post.optics.mask_radius = 0.9f;
  settings.post.optics.mask_cut = 0.7f;
  const Taken masked = RenderBench(scene, kSize, settings).take(poses, view, outputs);
  const auto depth = masked.plane<float>(wire::kDepthF32);
  const auto instance = masked.plane<uint32_t>(wire::kInstanceU32),
             whole_instance = whole.plane<uint32_t>(wire::kInstanceU32);
  const auto normal = masked.plane<uint64_t>(wire::kNormal),
             linear = masked.plane<uint64_t>(wire::kColorLinearF16);
  const auto position = masked.plane<glm::vec4>(wire::kPositionF32),
             whole_position = whole.plane<glm::vec4>(wire::kPositionF32);
  uint32_t inside = 0;
  for (uint32_t y = 0; y < kSize.height; ++y) {
    for (uint32_t x = 0; x < kSize.width; ++x) {
      const double right = (x + 0.5 - 32) / 24, up = (y + 0.5 - 24) / 24;
      const double away = std::max(std::hypot(right, up) - 0.9f, std::abs(up) - 0.7f);
      const size_t i = size_t{y} * kSize.width + x;
      if (away > 0) {
        EXPECT_TRUE(std::isinf(depth[i]) && instance[i] == 0 && normal[i] == 0);
        EXPECT_EQ(linear[i], uint64_t{0x3c00} << 48);
        EXPECT_EQ(position[i], glm::vec4(0));
        if (away * 24 > 1) {
          EXPECT_EQ(pixel(masked.image, x, y), glm::ivec3(0));
        }
      } else {
        ++inside;
        EXPECT_EQ(instance[i], whole_instance[i]);
        EXPECT_EQ(position[i], whole_position[i]);
        EXPECT_NE(normal[i], 0u);
        if (away * 24 < -1) {
          EXPECT_EQ(pixel(masked.image, x, y), pixel(whole.image, x, y));
        }
      }
    }
  }
  EXPECT_EQ(inside, static_cast<uint32_t>(std::ranges::count(instance, whole_instance[0])));
  // Of the disc of 0.9 without the two caps beyond 0.7, in pixels of a 24th.
  const double area = 2 * 24 * 24 * (0.7 * std::sqrt(0.81 - 0.49) + 0.81 * std::asin(0.7 / 0.9));
  EXPECT_NEAR(inside, area, 0.02 * area);
}

TEST_F(Sensor, OpticsFollowADistortion) {
  constexpr VkExtent2D kSize{64, 48};
  const passes::Intrinsics camera{
      .fx_px = 40, .fy_px = 40, .cx_px = 31.5f, .cy_px = 23.5f, .image_px = {64, 48}};
  passes::Lens lens;
  lens.model = passes::LensModel::plumb_bob;
  lens.coefficients = {-0.12f, 0.01f, 0, 0, 0};
  const Result<passes::Intrinsics> pinhole = passes::pinhole_behind(camera, lens, 1024);
  ASSERT_TRUE(pinhole);
  const VkExtent2D behind{pinhole->image_px.x, pinhole->image_px.y};
  const scene::Scene scene = wall(glowing(glm::vec3(0.98f)), 2);
  const state::PoseState poses(scene);
  settings::DrawSettings settings = linear_sensor();
  settings.post.optics.vignette = 3;
  settings.post.optics.mask_radius = 0.9f;
  RenderBench bench(scene, behind, settings);
  const wire::ImageOutputs outputs(wire::kColorSrgb8 | wire::kInstanceU32 | wire::kDepthF32);
  const passes::LensPass::Wanted wanted{camera, lens, outputs, 0.9f, 0, true};
  passes::LensPass lens_pass(device());
  const passes::View view = passes::make_view(*pinhole, glm::mat4(1));
  const passes::PreparedFrame prepared =
      bench.prepare({.outputs = passes::pinhole_outputs(outputs), .distorts = true});
  gpu::Recorder& recorder = bench.frames().begin();
  gpu::StagingRing& staging = bench.frames().staging();
  passes::SceneRenderer& renderer = bench.renderer();
  renderer.record(prepared, recorder, staging, poses, view);
  lens_pass.record(
      recorder, staging,
      {*pinhole, nullptr, &renderer.planes(), renderer.plane_ranges(), renderer.undeveloped_light()}, wanted);
  gpu::Image& developed = renderer.develop(recorder, staging, lens_pass.light(), kSize, view, poses);
  gpu::ReadbackRing<int> readback(device());
  readback.record(recorder, &developed, kSize, {&lens_pass.result(), lens_pass.result_bytes()}, 0);
  readback.submitted(bench.frames().submit());
  sinks::FrameImage image;
  image.width = kSize.width;
  image.height = kSize.height;
  Taken planes;
  planes.places = lens_pass.places();
  readback.drain([&](int, VkExtent2D, std::span<const uint8_t> bytes) {
    const size_t color_bytes = size_t{4} * kSize.width * kSize.height;
    image.rgba8.assign(bytes.begin(), bytes.begin() + color_bytes);
    planes.planes.assign(bytes.begin() + color_bytes, bytes.end());
  });
  const auto instance = planes.plane<uint32_t>(wire::kInstanceU32);
  for (uint32_t y = 0; y < kSize.height; ++y) {
    for (uint32_t x = 0; x < kSize.width; ++x) {
      const double away = std::hypot(x + 0.5 - 32, y + 0.5 - 24) - 0.9 * 24;
      EXPECT_EQ(instance[y * kSize.width + x] == 0, away > 0) << x << ", " << y;
      if (away > 1) {
        EXPECT_EQ(pixel(image, x, y), glm::ivec3(0));
      } else if (away < -1) {
        const glm::dvec2 point = *passes::undistort(lens, (glm::dvec2(x, y) - glm::dvec2(31.5, 23.5)) / 40.0);
        const double cosine = 1 / std::sqrt(1 + glm::dot(point, point));
        EXPECT_NEAR(pixel(image, x, y).g, 255 * 0.98 * std::pow(cosine, 3), 1.5) << x << ", " << y;
      }
    }
  }
}

TEST_F(Sensor, AberrationMagnifiesRedAndBlue) {
  constexpr VkExtent2D kSize{96, 64};
  SceneBuilder builder = camera_at_origin();
  const uint32_t texture = builder.texture(64, 64, false, [](float u, float v) {
    const float value = 0.5f + 0.4f * std::sin(20 * u) * std::cos(14 * v);
    return glm::vec4(value, value, value, 1);
  });
  scene::Material material = glowing(glm::vec3(1));
  material.emissive_texture.texture = texture;
  builder.mesh_node("wall", builder.quad(builder.material(material), 0.6f), wall_at(1));
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings = linear_sensor();
  const sinks::FrameImage plain = drawn(scene, settings, kSize);
  settings.post.optics.aberration = 0.03f;
  const sinks::FrameImage image = drawn(scene, settings, kSize);
  const auto between = [&](double x, double y, int channel) {
    const double fx = std::clamp(x - 0.5, 0.0, kSize.width - 1.0),
                 fy = std::clamp(y - 0.5, 0.0, kSize.height - 1.0);
    const auto column = static_cast<uint32_t>(fx), row = static_cast<uint32_t>(fy);
    double sum = 0;
    for (const uint32_t dx : {0u, 1u})
      for (const uint32_t dy : {0u, 1u})
        sum += (dx ? fx - column : 1 - fx + column) * (dy ? fy - row : 1 - fy + row) *
               pixel(plain, std::min(column + dx, kSize.width - 1),
                     std::min(row + dy, kSize.height - 1))[channel];
    return sum;
  };
  double moved = 0;
  for (uint32_t y = 0; y < kSize.height; ++y) {
    for (uint32_t x = 0; x < kSize.width; ++x) {
      const glm::ivec3 found = pixel(image, x, y), before = pixel(plain, x, y);
      const double right = x + 0.5 - 48, down = y + 0.5 - 32;
      EXPECT_EQ(found.g, before.g);
      EXPECT_NEAR(found.r, between(48 + 0.97 * right, 32 + 0.97 * down, 0), 1.5) << x << ", " << y;
      EXPECT_NEAR(found.b, between(48 + 1.03 * right, 32 + 1.03 * down, 2), 1.5) << x << ", " << y;
      moved = std::max<double>(moved, std::abs(found.r - before.r));
    }
  }
  EXPECT_GT(moved, 10);
}

struct Statistics {
  double mean = 0, variance = 0;
};

// Of the bytes of frames of one wall. Frames differ by their view.
Statistics noise_of(RenderBench& bench, const scene::Scene& scene, uint32_t frames) {
  const state::PoseState poses(scene);
  double sum = 0, squares = 0, count = 0;
  for (uint32_t frame = 0; frame < frames; ++frame) {
    passes::View view = first_camera_view(scene, poses, {64, 64});
    view.clip_from_world[3][0] += 1e-5f * static_cast<float>(frame);
    const sinks::FrameImage image = bench.draw(poses, view);
    for (size_t i = 0; i < image.rgba8.size(); ++i) {
      if (i % 4 == 3) continue;
      const double value = image.rgba8[i];
      sum += value;
      squares += value * value;
      ++count;
    }
  }
  return {sum / count, squares / count - sum / count * (sum / count)};
}

settings::DrawSettings noisy(float full_well, float read_noise, float dark_signal) {
  settings::DrawSettings settings = linear_sensor();
  settings.post.optics.full_well = full_well;
  settings.post.optics.read_noise = read_noise;
  settings.post.optics.dark_signal = dark_signal;
  settings.post.optics.prnu_percent = settings.post.optics.dsnu = 0;
  return settings;
}

// EMVA 1288: variance = K^2 sigma_d^2 + 1/12 + K (mean - mean in the dark), in bytes.
TEST_F(Sensor, PhotonTransferIsThatOfEmva1288) {
  const scene::Scene scene = wall(glowing(glm::vec3(0.25f)), 2);
  for (const float full_well : {120.0f, 2000.0f}) {  // few electrons and many
    const double gain = 255 / double{full_well};
    const double read_noise = 0.02 * double{full_well}, dark_signal = 0.1 * double{full_well};
    settings::DrawSettings settings =
        noisy(full_well, static_cast<float>(read_noise), static_cast<float>(dark_signal));
    RenderBench bench(scene, {64, 64}, settings);
    std::vector<Statistics> found;
    for (const float exposure : {1e-6f, 0.4f, 1.6f}) {
      settings.post.exposure = exposure;
      bench.renderer().apply(settings);
      found.push_back(noise_of(bench, scene, 16));
    }
    const double dark = gain * gain * read_noise * read_noise + 1.0 / 12;
    EXPECT_NEAR(found[0].variance, dark, 0.05 * dark) << full_well;
    EXPECT_NEAR(found[0].mean, gain * dark_signal, 0.01 * gain * dark_signal);
    for (const size_t bright : {1u, 2u}) {
      const double slope =
          (found[bright].variance - found[0].variance) / (found[bright].mean - found[0].mean);
      EXPECT_NEAR(slope, gain, 0.02 * gain) << full_well << " " << bright;
    }
    EXPECT_NEAR(found[2].mean - found[0].mean, 255 * 0.4, 0.5);
  }
}

TEST_F(Sensor, NoiseBelongsToSeedFrameAndView) {
  const scene::Scene scene = wall(glowing(glm::vec3(0.4f)), 2);
  const state::PoseState poses(scene);
  constexpr VkExtent2D kSize{32, 24};
  settings::DrawSettings settings = noisy(1000, 5, 0);
  RenderBench bench(scene, kSize, settings);
  const passes::View view = first_camera_view(scene, poses, kSize);
  passes::View other = view;
  other.clip_from_world[3][0] += 1e-4f;
  const std::vector<uint8_t> first = bench.draw(poses, view).rgba8;
  EXPECT_NE(first, bench.draw(poses, other).rgba8);
  EXPECT_EQ(first, bench.draw(poses, view).rgba8) << "whatever was drawn between";
  settings.post.optics.noise_seed = 1;
  bench.renderer().apply(settings);
  EXPECT_NE(first, bench.draw(poses, view).rgba8);
  EXPECT_EQ(passes::frame_hash(view, 5), passes::frame_hash(view, 5));
  EXPECT_NE(passes::frame_hash(view, 5), passes::frame_hash(view, 6));
  EXPECT_NE(passes::frame_hash(view, 5), passes::frame_hash(other, 5));
  EXPECT_NE(passes::frame_hash(view, 0), passes::frame_hash(view, std::nullopt));
  // Fixed patterns stay while frames change.
  settings = noisy(10'000, 0, 2000);
  settings.post.optics.prnu_percent = 2;
  settings.post.optics.dsnu = 100;
  for (const bool is_dark : {true, false}) {
    settings.post.exposure = is_dark ? 1e-6f : 1;
    bench.renderer().apply(settings);
    std::vector<double> mean(first.size());
    constexpr int kFrames = 24;
    for (int frame = 0; frame < kFrames; ++frame) {
      other.clip_from_world[3][0] += 1e-4f;
      const std::vector<uint8_t> image = bench.draw(poses, other).rgba8;
      for (size_t i = 0; i < image.size(); ++i) mean[i] += image[i] / double{kFrames};
    }
    double sum = 0, squares = 0, count = 0;
    for (size_t i = 0; i < mean.size(); ++i) {
      if (i % 4 == 3) continue;
      sum += mean[i];
      squares += mean[i] * mean[i];
      ++count;
    }
    const double deviation = std::sqrt(squares / count - sum / count * (sum / count)) / 255 * 10'000;
    const double electrons = is_dark ? 0 : 4000;
    const double wanted = std::hypot(100, std::hypot(0.02 * electrons, std::sqrt(electrons / kFrames)));
    EXPECT_NEAR(deviation, wanted, 0.05 * wanted) << is_dark;
  }
}

// Bright and dark squares before a dim wall.
scene::Scene chequers() {
  SceneBuilder builder = camera_at_origin();
  builder.mesh_node("wall", builder.quad(builder.material(glowing(glm::vec3(26, 15, 8) / 255.0f)), 3),
                    wall_at(2));
  const uint32_t bright = builder.quad(builder.material(glowing(glm::vec3(230, 128, 102) / 255.0f)), 0.17f);
  int number = 0;
  for (const float x : {-1.0f, -0.3f, 0.5f, 1.2f})
    for (const float y : {-0.8f, 0.1f, 0.7f})
      builder.mesh_node("square " + std::to_string(number++), bright, wall_at(1.9f, {x, y}));
  return builder.build();
}

glm::dvec3 mean_of(const sinks::FrameImage& image) {
  glm::dvec3 sum(0);
  for (uint32_t y = 0; y < image.height; ++y)
    for (uint32_t x = 0; x < image.width; ++x) sum += glm::dvec3(pixel(image, x, y));
  return sum / (double{1} * image.width * image.height);
}

TEST_F(Sensor, FogKeepsTheMean) {
  const scene::Scene scene = chequers();
  for (const VkExtent2D size : {VkExtent2D{128, 96}, VkExtent2D{101, 67}}) {
    settings::DrawSettings settings = linear_sensor();
    const sinks::FrameImage clear = drawn(scene, settings, size);
    const glm::dvec3 wanted = mean_of(clear);
    RenderBench bench(scene, size, settings);
    for (const float blur : {0.2f, 2.0f, 10.0f, 45.0f}) {
      for (const float veil : {0.0f, 0.3f, 1.0f}) {
        settings.post.optics.fog = 1;
        settings.post.optics.fog_blur_deg = blur;
        settings.post.optics.fog_veil = veil;
        bench.renderer().apply(settings);
        const sinks::FrameImage foggy = bench.draw_at_rest();
        const glm::dvec3 found = mean_of(foggy);
        for (int channel = 0; channel < 3; ++channel)
          EXPECT_NEAR(found[channel], wanted[channel], 0.01 * wanted[channel] + 0.1) << blur << " " << veil;
        if (veil == 1) {
          EXPECT_NEAR(pixel(foggy, 3, 3).r, wanted.r, 1) << "the veil is even";
        }
      }
    }
  }
}

TEST_F(Sensor, FogBlursByItsAngle) {
  // A bright line: its variance is that of the blur.
  constexpr VkExtent2D kSize{161, 33};
  SceneBuilder builder = camera_at_origin(0.6f);
  builder.mesh_node("line", builder.quad(builder.material(glowing(glm::vec3(8))), 0.03f), wall_at(2));
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings = linear_sensor();
  settings.post.optics.fog = 1;
  settings.post.optics.fog_veil = 0;
  settings.post.optics.fog_blur_deg = 4;
  settings.post.exposure = 4;
  const double focal_px = kSize.height / (2 * std::tan(0.3));
  const double wanted = focal_px * std::tan(4 * std::numbers::pi / 180);
  const sinks::FrameImage image = drawn(scene, settings, kSize);
  double sum = 0, squares = 0;
  for (uint32_t x = 0; x < kSize.width; ++x) {
    const double value = pixel(image, x, kSize.height / 2).g, right = x + 0.5 - 0.5 * kSize.width;
    sum += value;
    squares += value * right * right;
  }
  EXPECT_NEAR(std::sqrt(squares / sum), wanted, 0.2 * wanted);
}

TEST_F(Sensor, DropsCoverTheirShareAndBelongToTheSeed) {
  constexpr VkExtent2D kSize{256, 192};
  const scene::Scene scene = chequers();
  settings::DrawSettings settings = linear_sensor();
  RenderBench bench(scene, kSize, settings);
  const sinks::FrameImage clear = bench.draw_at_rest();
  settings.post.optics.drops = 0.3f;
  settings.post.optics.drop_size_deg = 5;
  bench.renderer().apply(settings);
  const sinks::FrameImage dropped = bench.draw_at_rest();
  EXPECT_EQ(dropped.rgba8, bench.draw_at_rest().rgba8);
  uint32_t changed = 0;
  for (uint32_t y = 0; y < kSize.height; ++y)
    for (uint32_t x = 0; x < kSize.width; ++x) changed += pixel(clear, x, y) != pixel(dropped, x, y) ? 1 : 0;
  const double share = changed / (256.0 * 192);
  EXPECT_GT(share, 0.02) << "even ground looks the same through a drop";
  EXPECT_LT(share, 0.3);
  settings.post.optics.noise_seed = 7;
  bench.renderer().apply(settings);
  EXPECT_NE(dropped.rgba8, bench.draw_at_rest().rgba8);
}

TEST_F(Sensor, PresetAgreesAcrossRenderers) {
  constexpr VkExtent2D kSize{64, 48};
  SceneBuilder builder = camera_at_origin();
  builder.mesh_node("wall", builder.quad(builder.material(lambert({0.7f, 0.3f, 0.25f})), 1), wall_at(0.06f));
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings = settings::default_settings();
  ASSERT_EQ(settings::draw_setting("camera-preset").set("endoscope", settings), "");
  settings.samples = 4;
  settings.post.optics.full_well = 1e6f;
  const sinks::FrameImage raster = drawn(scene, settings, kSize);
  settings.path = settings::PathSettings{.samples_per_pixel = 32, .bounces = 0, .lens = settings.post.lens};
  const sinks::FrameImage traced = drawn(scene, settings, kSize);
  double difference = 0;
  for (size_t i = 0; i < raster.rgba8.size(); ++i) difference += std::abs(raster.rgba8[i] - traced.rgba8[i]);
  EXPECT_LT(difference / static_cast<double>(raster.rgba8.size()), 2);
  EXPECT_GT(pixel(raster, 32, 24).r, 90);
  EXPECT_EQ(pixel(raster, 0, 0), glm::ivec3(0)) << "the mask";
}

}  // namespace
}  // namespace fire3dv::test
