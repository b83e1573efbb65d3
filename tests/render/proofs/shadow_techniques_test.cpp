// Render test of shadow techniques: hybrid, rays alone by ray query or ray-tracing pipeline give the same
// shadows. Closed-form scenes also cover maps alone.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/render/support/proof_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

using glm::vec3;
using settings::RayBackEnd;
using settings::ShadowMethod;

constexpr VkExtent2D kExtent{128, 96};

scene::Light lamp_at_all() {
  scene::Light lamp;
  lamp.intensity = 3;
  return lamp;
}

uint32_t fence(SceneBuilder& builder) {
  scene::Material material = matte({1, 1, 1});
  material.alpha_mode = scene::AlphaMode::mask;
  material.double_sided = true;
  material.base_color_texture.texture = builder.texture(64, 64, true, [](float u, float v) {
    return glm::vec4(1, 1, 1, glm::fract(4 * u) > 0.5f && glm::fract(4 * v) > 0.5f ? 0 : 1);
  });
  return builder.quad(builder.material(material), 0.5f);
}

scene::Scene yard(float radius, float size = 1) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({0.8f, 0.8f, 0.8f}));
  builder.mesh_node("ground", builder.quad(white, 4 * size), glm::mat4(1));
  builder.mesh_node("box", builder.box(white, size * vec3(0.2f, 0.3f, 0.2f)),
                    at(size * vec3(0.6f, 0.3f, 0.1f)));
  builder.mesh_node("ball", builder.sphere(white, 0.3f * size, 64), at(size * vec3(-0.5f, 0.3f, -0.3f)));
  builder.mesh_node("fence", fence(builder),
                    at(size * vec3(0, 0.6f, -0.6f)) * glm::rotate(glm::mat4(1), 1.2f, vec3(1, 0, 0)) *
                        glm::scale(glm::mat4(1), vec3(size)));
  scene::Light light = sun({1, 1, 1}, 1.5f);
  light.angular_radius_rad = radius;
  builder.light_node(light, shining_towards({-0.5f, -1, 0.4f}));
  scene::Light lamp = lamp_at_all();
  lamp.intensity *= size * size;
  lamp.radius_m = radius * size;
  builder.light_node(lamp, at(size * vec3(0.2f, 1.2f, 0.5f)));
  builder.camera_node("camera", size * vec3(0.6f, 1.6f, 2.2f), size * vec3(0, 0.1f, 0));
  return builder.build();
}

sinks::FrameImage drawn(const scene::Scene& scene, const settings::DrawSettings& settings,
                        VkExtent2D extent = kExtent) {
  return RenderBench(scene, extent, settings).draw_at_rest();
}

settings::DrawSettings forward(settings::DrawSettings settings) {
  settings.raster = settings::RasterPath::forward;
  return settings;
}

class ShadowWays : public ValidationIsSilent {};

TEST_F(ShadowWays, RayBackEndsAreIdentical) {
  ASSERT_TRUE(device().report().ray_tracing_pipeline)
      << "this driver has no ray-tracing pipeline; install a newer Mesa";
  for (float radius : {0.0f, 0.08f}) {
    const scene::Scene scene = yard(radius);
    for (uint32_t samples : {1u, 4u}) {
      SCOPED_TRACE(testing::Message() << radius << ", " << samples << " samples");
      settings::DrawSettings query = shadowed_by(ShadowMethod::ray, true, samples), pipeline = query;
      query.shadows.back_end = RayBackEnd::query;
      pipeline.shadows.back_end = RayBackEnd::pipeline;
      RenderBench by_pipeline(scene, kExtent, pipeline);
      EXPECT_EQ(by_pipeline.renderer().settings().shadow_technique().back_end, RayBackEnd::pipeline);
      EXPECT_TRUE(matches_image(by_pipeline.draw_at_rest(), drawn(scene, query), "ways_back_ends",
                                Tolerance::exact()));
    }
  }
}

TEST_F(ShadowWays, HybridAllAndForwardAgree) {
  for (uint32_t samples : {1u, 4u}) {
    SCOPED_TRACE(samples);
    const scene::Scene scene = yard(0);
    // Large enough that the terminator of the balls covers a small share of the image. Its position within a
    // pixel depends on which of the pixel's small triangles is shaded.
    const VkExtent2D extent{256, 192};
    const sinks::FrameImage all = drawn(scene, shadowed_by(ShadowMethod::ray, false, samples), extent);
    EXPECT_TRUE(matches_image(drawn(scene, shadowed_by(ShadowMethod::ray, true, samples), extent), all,
                              "ways_hybrid", Tolerance::colour()));
    EXPECT_TRUE(matches_image(drawn(scene, forward(shadowed_by(ShadowMethod::ray, false, samples)), extent),
                              all, "ways_forward", Tolerance::colour()));
  }
}

TEST_F(ShadowWays, HybridTracesFewerRays) {
  const scene::Scene scene = yard(0);
  uint64_t rays[2];
  for (bool hybrid : {false, true}) {
    RenderBench bench(scene, kExtent, shadowed_by(ShadowMethod::ray, hybrid));
    for (uint32_t i = 0; i < 2 * gpu::kFramesInFlight; ++i) bench.draw_at_rest();
    rays[hybrid] = bench.renderer().counts().shadow_rays;
  }
  EXPECT_GT(rays[0], 5000u);
  EXPECT_LT(rays[1], rays[0] / 2);
  EXPECT_GT(rays[1], 0u);
}

// Rays beyond the capacity of the ray list are traced per pixel.
TEST_F(ShadowWays, FewRaysFitTheBuffer) {
  const scene::Scene scene = yard(0);
  for (RayBackEnd back_end : {RayBackEnd::query, RayBackEnd::pipeline}) {
    for (uint32_t samples : {1u, 4u}) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(back_end) << ", " << samples << " samples");
      settings::DrawSettings settings = shadowed_by(ShadowMethod::ray, true, samples);
      settings.shadows.back_end = back_end;
      RenderBench all(scene, kExtent, settings);
      sinks::FrameImage of_all;
      for (uint32_t i = 0; i < 2 * gpu::kFramesInFlight; ++i) of_all = all.draw_at_rest();
      const auto rays = static_cast<uint32_t>(all.renderer().counts().shadow_rays);
      ASSERT_GT(rays, 100u);
      for (uint32_t room : {1u, 70u, rays - 1, rays}) {
        SCOPED_TRACE(room);
        settings.shadows.max_listed_rays = room;
        EXPECT_TRUE(matches_image(drawn(scene, settings), of_all, "ways_room", Tolerance::exact()));
      }
    }
  }
}

// A 1 m box on the ground, the sun at 45 degrees: its shadow extends 1 m from its side. Seen from above, in
// metres: the image shows 4 x 3 m.
TEST_F(ShadowWays, BoxShadowMatchesGeometry) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({1, 1, 1}));
  builder.mesh_node("ground", builder.quad(white, 10), glm::mat4(1));
  builder.mesh_node("box", builder.box(white, vec3(0.5f)), at({-0.5f, 0.5f, 0}));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({1, -1, 0}));
  const scene::Scene scene = builder.build();
  for (auto [method, hybrid] : {std::pair(ShadowMethod::ray, true), std::pair(ShadowMethod::ray, false),
                                std::pair(ShadowMethod::map, false)}) {
    SCOPED_TRACE(testing::Message() << static_cast<int>(method) << ", " << hybrid);
    ProofBench bench({160, 120}, shadowed_by(method, hybrid));
    bench.show(scene);
    scene::Camera camera;
    camera.orthographic = true;
    camera.half_extent_m = {2, 1.5f};
    const sinks::FrameImage image = bench.draw(camera, passes::look_at_pose({0.5f, 10, 0}, {0.5f, 0, 0}));
    // A map texel is at most about 1.8 m / 256 = 7 mm, less than half a pixel (12.5 mm).
    uint32_t wrong = 0;
    for (uint32_t y = 0; y < 120; ++y) {
      for (uint32_t x = 0; x < 160; ++x) {
        const float right = (static_cast<float>(x) + 0.5f) / 40 - 2,
                    up = (static_cast<float>(y) + 0.5f) / 40 - 1.5f;
        // Image right is the world's +X or -X, depending on the tie break of the vertical view.
        const glm::mat4 pose = passes::look_at_pose({0.5f, 10, 0}, {0.5f, 0, 0});
        const vec3 place = vec3(pose[3]) + right * vec3(pose[0]) - up * vec3(pose[1]);
        if (place.x < 0 && place.x > -1 && std::abs(place.z) < 0.5f) continue;  // the box itself
        const bool shadowed = place.x > 0 && place.x < 1 && std::abs(place.z) < 0.5f;
        wrong += (pixel(image, x, y).g < 64) != shadowed;
      }
    }
    EXPECT_EQ(wrong, 0u);
  }
}

// A half plane 1 m above the ground under a vertical sun of 0.05 rad radius: the penumbra is 0.1 m wide.
TEST_F(ShadowWays, PenumbraWidthMatchesGeometry) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({1, 1, 1}));
  builder.mesh_node("ground", builder.quad(white, 10), glm::mat4(1));
  builder.mesh_node("roof", builder.box(white, {2, 0.001f, 2}), at({-2, 1, 0}));
  scene::Light light = sun({1, 1, 1}, 3);
  light.angular_radius_rad = 0.05f;
  builder.light_node(light, shining_towards({0, -1, 0}));
  const scene::Scene scene = builder.build();
  ProofBench bench(kExtent, shadowed_by(ShadowMethod::ray));
  bench.show(scene);
  scene::Camera camera;
  camera.orthographic = true;
  camera.half_extent_m = {0.2f, 0.15f};
  camera.near_m = 0.001f;
  const glm::mat4 pose = passes::look_at_pose({0, 0.5f, 0}, {0, 0, 0});
  const sinks::FrameImage image = bench.draw(camera, pose);
  EXPECT_TRUE(matches_image(bench.draw(camera, pose), image, "ways_penumbra", Tolerance::exact()));
  // Mean over all pixels at the same distance from the edge.
  const float per_pixel = 0.4f / kExtent.width;
  std::vector<double> sum(kExtent.width + kExtent.height), count(sum.size());
  double brightest = 0;
  auto light_of = [](int channel) {
    const double v = channel / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  for (uint32_t y = 0; y < kExtent.height; ++y) {
    for (uint32_t x = 0; x < kExtent.width; ++x) {
      const vec3 place = (static_cast<float>(x) + 0.5f - kExtent.width / 2.0f) * per_pixel * vec3(pose[0]) -
                         (static_cast<float>(y) + 0.5f - kExtent.height / 2.0f) * per_pixel * vec3(pose[1]);
      const auto bin = static_cast<size_t>((place.x + 0.2f) / per_pixel);
      sum[bin] += light_of(pixel(image, x, y).g);
      ++count[bin];
      brightest = std::max(brightest, light_of(pixel(image, x, y).g));
    }
  }
  ASSERT_GT(brightest, 0.3);
  int compared = 0;
  for (size_t bin = 0; bin < sum.size(); ++bin) {
    if (count[bin] == 0) continue;
    const double from_edge = (static_cast<double>(bin) + 0.5) * per_pixel - 0.2;
    const double t = std::clamp(from_edge / 0.05, -1.0, 1.0);  // position on the sun's disc, in radii
    const double lit = 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / 3.14159265;
    EXPECT_NEAR(sum[bin] / count[bin] / brightest, lit, 0.04) << from_edge << " m from the edge";
    ++compared;
  }
  EXPECT_GT(compared, 80);
}

// The same scene at the size of a hand and of a valley gives the same image.
TEST_F(ShadowWays, SizesDoNotMatter) {
  for (auto [method, hybrid] : {std::pair(ShadowMethod::ray, true), std::pair(ShadowMethod::ray, false)}) {
    const sinks::FrameImage usual = drawn(yard(0), shadowed_by(method, hybrid));
    for (float size : {1.0f / 500, 1000.0f}) {
      scene::Scene scene = yard(0, size);
      for (scene::Camera& camera : scene.cameras) camera.near_m *= size;
      EXPECT_TRUE(
          matches_image(drawn(scene, shadowed_by(method, hybrid)), usual, "ways_size", Tolerance::colour()))
          << size;
    }
  }
}

TEST_F(ShadowWays, MaskedCastersMatchInMaps) {
  SceneBuilder builder;
  builder.mesh_node("ground", builder.quad(builder.material(matte({1, 1, 1})), 4), glm::mat4(1));
  builder.mesh_node("fence", fence(builder), at({0, 0.5f, 0}));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({1, -1, 0}));
  builder.camera_node("camera", {1.2f, 1.5f, 0.4f}, {0.5f, 0, 0});
  const scene::Scene scene = builder.build();
  const sinks::FrameImage rays = drawn(scene, shadowed_by(ShadowMethod::ray, false));
  const sinks::FrameImage maps = drawn(scene, shadowed_by(ShadowMethod::map));
  const Brightness seen = compare_brightness(maps, rays, 3 * 40);
  EXPECT_GT(compare_brightness(rays, drawn(scene, plain_settings()), 3 * 40).darker, 600u)
      << "the fence casts nothing";
  EXPECT_LE(seen.brighter + seen.darker, kExtent.width * kExtent.height / 100) << "only at edges";
  EXPECT_TRUE(matches_image(drawn(scene, shadowed_by(ShadowMethod::ray, true)), rays, "ways_masked",
                            Tolerance::colour()));
}

// A clearcoat normal map may face a light that the base surface turns away from.
TEST_F(ShadowWays, CoatNormalsAreShadowed) {
  SceneBuilder builder;
  scene::Material coated = matte({0, 0, 0});
  coated.clearcoat = 1;
  coated.clearcoat_roughness = 0.6f;
  coated.clearcoat_normal_texture.texture =
      builder.texture(4, 4, false, [](float, float) { return glm::vec4(0.02f, 0.5f, 0.6f, 1); });
  coated.normal_texture.texture =
      builder.texture(4, 4, false, [](float, float) { return glm::vec4(0.98f, 0.5f, 0.6f, 1); });
  // A wall lit at a grazing angle, with an occluder between.
  const glm::mat4 upright = glm::rotate(glm::mat4(1), 1.5707963f, vec3(1, 0, 0));
  builder.mesh_node("wall", builder.quad(builder.material(coated), 1), upright);
  builder.mesh_node("post", builder.box(builder.material(matte({1, 1, 1})), {0.1f, 6, 0.3f}), at({-3, 0, 0}));
  builder.light_node(sun({1, 1, 1}, 40), shining_towards({1, -0.1f, -0.1f}));
  builder.camera_node("camera", {0.4f, 0.2f, 2.5f}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  const sinks::FrameImage reference = drawn(scene, forward(shadowed_by(ShadowMethod::ray, false)));
  const sinks::FrameImage unshadowed = drawn(scene, plain_settings());
  EXPECT_GT(compare_brightness(unshadowed, reference, 30).brighter, 500u) << "the coat reflects nothing";
  for (bool hybrid : {false, true}) {
    EXPECT_TRUE(matches_image(drawn(scene, shadowed_by(ShadowMethod::ray, hybrid)), reference, "ways_coat",
                              Tolerance::colour()));
  }
}

// Faces at 20 degrees share pixels; one faces away from the light, the other lies in shadow.
TEST_F(ShadowWays, FaceEdgeStaysShadowed) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({1, 1, 1}));
  std::vector<vec3> positions;
  std::vector<uint32_t> indices;
  for (uint32_t i = 0; i < 60;
       ++i) {  // a pleated sheet: 20 degrees between folds, each a third of a pixel wide
    const float x = 0.006f * static_cast<float>(i), y = i % 2 ? 0.00106f : 0;
    positions.emplace_back(x - 0.18f, y, -0.2f);
    positions.emplace_back(x - 0.18f, y, 0.2f);
    if (i) indices.insert(indices.end(), {2 * i - 2, 2 * i - 1, 2 * i, 2 * i, 2 * i - 1, 2 * i + 1});
  }
  builder.mesh_node("pleats", builder.triangles(white, positions, indices), glm::mat4(1));
  builder.mesh_node("roof", builder.box(white, {4, 0.4f, 4}), at({-6, 0.3f, 0}));
  builder.light_node(sun({1, 1, 1}, 30), shining_towards({1, -0.05f, 0}));
  builder.camera_node("camera", {0.02f, 1.2f, 0.01f}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  const settings::DrawSettings settings = shadowed_by(ShadowMethod::ray, true, 4);
  uint32_t lit = 0, lit_without = 0;
  const sinks::FrameImage image = drawn(scene, settings), without = drawn(scene, plain_settings(4));
  for (uint32_t y = 0; y < kExtent.height; ++y) {
    for (uint32_t x = 0; x < kExtent.width; ++x) {
      lit += pixel(image, x, y) != glm::ivec3(0);
      lit_without += pixel(without, x, y) != glm::ivec3(0);
    }
  }
  EXPECT_GT(lit_without, 300u);
  EXPECT_EQ(lit, 0u);
}

// In an orthographic view, faces at the image's border face the view direction but not the eye point.
TEST_F(ShadowWays, ParallelViewsSeeSameSides) {
  SceneBuilder builder;
  scene::Material sheet = matte({0.8f, 0.6f, 0.4f});
  const uint32_t one_sided = builder.material(sheet);
  sheet.double_sided = true;
  const uint32_t two_sided = builder.material(sheet);
  for (int i = 0; i < 8; ++i) {
    const float x = static_cast<float>(i) - 3.5f;
    builder.mesh_node("leaf" + std::to_string(i), builder.quad(i % 2 ? one_sided : two_sided, 0.4f),
                      at({x, i < 4 ? 0.8f : -0.8f, 0}) *
                          glm::rotate(glm::mat4(1), 0.35f * static_cast<float>(i % 5) - 0.4f, vec3(0, 0, 1)) *
                          glm::rotate(glm::mat4(1), 0.25f, vec3(1, 0, 0)));
    builder.mesh_node("ball" + std::to_string(i), builder.sphere(one_sided, 0.3f, 32), at({x, 0, 0}));
  }
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-0.3f, 0.2f, -1}));
  scene::Scene scene = builder.build();
  scene::Camera camera;
  camera.orthographic = true;
  camera.half_extent_m = {4, 3};
  const glm::mat4 pose = passes::look_at_pose({0, 0, 0.7f}, {0, 0, 0});
  ProofBench visibility(kExtent, plain_settings()), reference(kExtent, forward(plain_settings()));
  visibility.show(scene);
  reference.show(scene);
  EXPECT_TRUE(matches_image(visibility.draw(camera, pose), reference.draw(camera, pose), "ways_parallel",
                            Tolerance::colour()));
}

// Holes and bars at least two texels wide transmit light and shadow completely.
TEST_F(ShadowWays, GrillesLoseLightBelowTwoTexels) {
  // The caster is 2 m wide: a texel of its map is 2.02 m / 2048, slightly below 1 mm.
  const float texel_m = 2 * 1.01f / kFineMapSide * 1.001f;
  for (float hole_texels : {0.5f, 1.0f, 2.9f, 4.0f, 8.0f}) {
    SCOPED_TRACE(hole_texels);
    const float hole = hole_texels * texel_m, period = hole + 12 * texel_m;
    SceneBuilder builder;
    const uint32_t white = builder.material(matte({1, 1, 1}));
    builder.mesh_node("ground", builder.quad(white, 4), glm::mat4(1));
    std::vector<vec3> positions;
    std::vector<uint32_t> indices;
    auto bar = [&](float x0, float x1) {
      const auto a = static_cast<uint32_t>(positions.size());
      for (vec3 p : {vec3(x0, 0, -1), vec3(x0, 0, 1), vec3(x1, 0, 1), vec3(x1, 0.001f, -1)})
        positions.push_back(p);
      indices.insert(indices.end(), {a, a + 1, a + 2, a, a + 2, a + 3});
    };
    for (int i = -4; i < 4; ++i)
      bar(static_cast<float>(i) * period, static_cast<float>(i + 1) * period - hole);
    bar(-1, -4 * period - hole);
    bar(4 * period, 1);
    scene::Material sheet = matte({1, 1, 1});
    sheet.double_sided = true;
    builder.mesh_node("grille", builder.triangles(builder.material(sheet), positions, indices),
                      at({0, 0.3f, 0}));
    builder.light_node(sun({1, 1, 1}, 3), shining_towards({0, -1, 0}));
    const scene::Scene scene = builder.build();
    // Seen from below the grille; a pixel is a tenth of the period.
    scene::Camera camera;
    camera.orthographic = true;
    camera.half_extent_m = {0.75f * period * 4 / 3, 0.75f * period};
    camera.near_m = 0.001f;
    const glm::mat4 pose = passes::look_at_pose({0, 0.2f, 0.3f}, {0, 0, 0.3f});
    ProofBench hybrid(kExtent, with_fine_maps(shadowed_by(ShadowMethod::ray, true))),
        all(kExtent, shadowed_by(ShadowMethod::ray, false));
    hybrid.show(scene);
    all.show(scene);
    const Brightness seen = compare_brightness(hybrid.draw(camera, pose), all.draw(camera, pose));
    EXPECT_EQ(seen.brighter, 0u);
    EXPECT_GT(seen.bright, 50u);
    if (hole_texels >= 2.9f) {
      EXPECT_EQ(seen.darker, 0u);
    }
  }
}

}  // namespace
}  // namespace fire3dv::test
