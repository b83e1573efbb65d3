// Render test of ray effects: a mirror against a mirrored camera, occlusion against form factors, and images
// that the effects must not change.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "tests/render/support/path_bench.h"
#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

class RayEffects : public ValidationIsSilent {};

constexpr VkExtent2D kRayEffectsSize{96, 64};

scene::Material metal(float roughness) {
  scene::Material material = matte(glm::vec3(1));
  material.metallic = 1;
  material.roughness = roughness;
  return material;
}

settings::DrawSettings traced(settings::RayEffects on,
                              settings::RayBackEnd back_end = settings::RayBackEnd::query) {
  settings::DrawSettings settings;
  settings.samples = 1;
  settings.post.fxaa = false;
  settings.environment = constant_environment({0.3f, 0.35f, 0.5f});
  settings.background.show_environment = true;
  settings.ray_effects.on = on;
  settings.ray_effects.back_end = back_end;
  return settings;
}

settings::RayEffects reflections() {
  settings::RayEffects on;
  on.reflections = true;
  return on;
}
settings::RayEffects ambient_occlusion() {
  settings::RayEffects on;
  on.ambient_occlusion = true;
  return on;
}
settings::RayEffects all_effects() {
  settings::RayEffects on;
  EXPECT_TRUE(settings::ray_effects_named("all", on));
  return on;
}

// Bodies on a floor at z > 0, lit by a sun with shadows, before a wall at z = 0.
void add_bodies(SceneBuilder& builder) {
  builder.mesh_node("floor", builder.quad(builder.material(matte({0.6f, 0.6f, 0.55f})), 6), at({0, -1, 6}));
  builder.mesh_node("box", builder.box(builder.material(matte({0.8f, 0.2f, 0.1f})), {0.3f, 0.5f, 0.3f}),
                    at({-0.7f, -0.5f, 1.2f}));
  scene::Material plastic = matte({0.1f, 0.3f, 0.8f});
  plastic.roughness = 0.3f;
  builder.mesh_node("ball", builder.sphere(builder.material(plastic), 0.4f, 48), at({0.5f, -0.6f, 1.5f}));
  builder.light_node(sun({1, 1, 0.9f}, 2.5f), shining_towards({0.4f, -1, -0.3f}));
}

glm::mat4 facing_z(glm::vec3 position) {
  return glm::rotate(at(position), glm::half_pi<float>(), glm::vec3(1, 0, 0));
}

const glm::vec3 kEye(0.4f, 0.1f, 3), kLooksAt(0, -0.4f, 0);

scene::Scene mirror_scene(float roughness) {
  SceneBuilder builder;
  add_bodies(builder);
  builder.mesh_node("mirror", builder.quad(builder.material(metal(roughness)), 20), facing_z({0, 0, 0}));
  builder.camera_node("camera", kEye, kLooksAt, 0.6f);
  return builder.build();
}

// Share of the pixels whose channels differ by `most` at most.
double share_within(const sinks::FrameImage& a, const sinks::FrameImage& b, int most) {
  size_t good = 0;
  const size_t pixels = a.rgba8.size() / 4;
  EXPECT_EQ(a.rgba8.size(), b.rgba8.size());
  for (size_t i = 0; i < pixels; ++i) {
    bool near = true;
    for (size_t c = 0; c < 4; ++c) near &= std::abs(a.rgba8[4 * i + c] - b.rgba8[4 * i + c]) <= most;
    good += near;
  }
  return static_cast<double>(good) / static_cast<double>(pixels);
}

sinks::FrameImage flipped(const sinks::FrameImage& image, VkExtent2D size) {
  sinks::FrameImage result = image;
  for (uint32_t y = 0; y < size.height; ++y) {
    for (uint32_t x = 0; x < size.width; ++x)
      std::copy_n(&image.rgba8[4 * (size_t{y} * size.width + size.width - 1 - x)], 4,
                  &result.rgba8[4 * (size_t{y} * size.width + x)]);
  }
  return result;
}

sinks::FrameImage drawn_with_rays(const scene::Scene& scene, const settings::DrawSettings& settings) {
  return RenderBench(scene, kRayEffectsSize, settings).draw_at_rest();
}

TEST_F(RayEffects, FlatMirrorMatchesMirroredCamera) {
  // The camera looks at the mirror from above the bodies, which its own view shows beside their mirror
  // images; the camera of the mirror image is behind the mirror, without it.
  SceneBuilder builder;
  add_bodies(builder);
  const glm::vec3 flip(1, 1, -1);
  builder.camera_node("camera", flip * kEye, flip * kLooksAt, 0.6f);
  const sinks::FrameImage truth = flipped(drawn_with_rays(builder.build(), traced({})), kRayEffectsSize);
  const scene::Scene scene = mirror_scene(0);
  const state::PoseState poses(scene);
  const sinks::FrameImage without = drawn_with_rays(scene, traced({}));
  // Only pixels of the mirror: the label plane tells them apart.
  for (const settings::RayBackEnd back_end : {settings::RayBackEnd::query, settings::RayBackEnd::pipeline}) {
    RenderBench bench(scene, kRayEffectsSize, traced(reflections(), back_end));
    ASSERT_EQ(bench.renderer().ray_effect_back_end(), back_end);
    passes::ImageOutputs outputs(wire::kColorSrgb8 | wire::kDepthF32);
    const Taken taken = bench.take(poses, first_camera_view(scene, poses, kRayEffectsSize), outputs);
    const std::vector<float> depth = taken.plane<float>(wire::kDepthF32);
    const glm::vec3 look = glm::normalize(kLooksAt - kEye);
    size_t mirror = 0, good = 0, changed = 0;
    for (size_t i = 0; i < depth.size(); ++i) {
      // Depth of the mirror's plane along the pixel's ray.
      const passes::View view = first_camera_view(scene, poses, kRayEffectsSize);
      const glm::vec2 ndc(
          (static_cast<float>(i % kRayEffectsSize.width) + 0.5f) / kRayEffectsSize.width * 2 - 1,
          (static_cast<float>(i / kRayEffectsSize.width) + 0.5f) / kRayEffectsSize.height * 2 - 1);
      const glm::vec3 ray =
          view.world_from_ndc_x * ndc.x + view.world_from_ndc_y * ndc.y + view.world_from_ndc_origin;
      const float plane_depth = kEye.z / -ray.z * glm::dot(ray, look);
      if (ray.z >= 0 || std::abs(depth[i] - plane_depth) > 1e-3f * plane_depth) continue;
      ++mirror;
      int worst = 0, change = 0;
      for (size_t c = 0; c < 4; ++c) {
        worst = std::max(worst, std::abs(taken.image.rgba8[4 * i + c] - truth.rgba8[4 * i + c]));
        change = std::max(change, std::abs(taken.image.rgba8[4 * i + c] - without.rgba8[4 * i + c]));
      }
      good += worst <= 2;
      changed += change > 10;
    }
    EXPECT_GT(mirror, kRayEffectsSize.width * kRayEffectsSize.height / 4);
    EXPECT_GT(static_cast<double>(changed), 0.3 * static_cast<double>(mirror))
        << "the mirror shows more than the sky";
    EXPECT_GE(static_cast<double>(good), 0.99 * static_cast<double>(mirror))
        << passes::describe_path_back_end(back_end);
  }
}

// Textures of mirrored surfaces have the mip levels of the distance by way of the mirror. Its sharpest level,
// read at single points, would be noise.
TEST_F(RayEffects, MirroredTextureIsFiltered) {
  const auto scene_of = [](bool mirrored) {
    SceneBuilder builder;
    scene::Material checks = matte(glm::vec3(0));
    checks.specular = 0;
    checks.emissive = glm::vec3(1);
    checks.emissive_texture.texture = builder.texture(64, 64, false, [](float u, float v) {
      return glm::vec4(glm::vec3((static_cast<int>(u * 64) + static_cast<int>(v * 64)) % 2 ? 1.0f : 0.0f), 1);
    });
    builder.mesh_node("floor", builder.quad(builder.material(checks), 8, 4), at({0, -1, 8}));
    if (mirrored)
      builder.mesh_node("mirror", builder.quad(builder.material(metal(0)), 20), facing_z({0, 0, 0}));
    const glm::vec3 flip(1, 1, mirrored ? 1 : -1);
    builder.camera_node("camera", flip * glm::vec3(0, 0, 1), flip * glm::vec3(0, -0.3f, 0), 0.5f);
    return builder.build();
  };
  const sinks::FrameImage truth = flipped(drawn_with_rays(scene_of(false), traced({})), kRayEffectsSize);
  const sinks::FrameImage seen = drawn_with_rays(scene_of(true), traced(reflections()));
  EXPECT_GT(share_within(seen, truth, 12), 0.95);
}

TEST_F(RayEffects, RoughReflectionsAgreeWithPaths) {
  SceneBuilder builder;
  add_bodies(builder);
  builder.mesh_node("mirror", builder.quad(builder.material(metal(0.3f)), 20), facing_z({0, 0, 0}));
  builder.camera_node("camera", {0, 0, 0.6f}, {0, -0.35f, 0}, 0.8f);  // sees the mirror alone
  const scene::Scene scene = builder.build();
  constexpr VkExtent2D kSmall{32, 24};
  // Lamps alone: hits take the environment without occlusion, paths with it.
  const auto by_lamps = [](settings::DrawSettings settings) {
    settings.environment_intensity = 0;
    return settings;
  };
  const std::vector<glm::dvec3> seen = linear_image(scene, kSmall, by_lamps(traced(reflections())));
  settings::DrawSettings paths = by_lamps(traced({}));
  paths.path = settings::PathSettings{.samples_per_pixel = 64, .bounces = 1, .seed = 1};
  const std::vector<glm::dvec3> truth = linear_image(scene, kSmall, paths);
  double error = 0, sum = 0, seen_sum = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    error += std::abs(seen[i].g - truth[i].g);
    sum += truth[i].g;
    seen_sum += seen[i].g;
  }
  RecordProperty("sum over the truth", std::to_string(seen_sum / sum));
  RecordProperty("error", std::to_string(error / sum));
  EXPECT_NEAR(seen_sum, sum, 0.03 * sum) << seen_sum / sum;
  EXPECT_LT(error, 0.12 * sum) << "noise of the paths, and a blur of 4 pixels of 24: " << error / sum;
}

TEST_F(RayEffects, BodyBeforeSkyIsUnchanged) {
  SceneBuilder builder;
  scene::Material coated = metal(0.2f);
  coated.metallic = 0.5f;
  coated.clearcoat = 1;
  coated.clearcoat_roughness = 0.05f;
  builder.mesh_node("ball", builder.sphere(builder.material(coated), 0.5f), glm::mat4(1));
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-1, -1, -1}));
  builder.camera_node("camera", {0, 0, 2}, {0, 0, 0}, 0.7f);
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings = traced(all_effects()), plain = traced({});
  settings.environment = plain.environment = nullptr;  // the studio
  // Two shaders with the same arithmetic: a driver may round them differently.
  EXPECT_EQ(share_within(drawn_with_rays(scene, settings), drawn_with_rays(scene, plain), 1), 1);
}

TEST_F(RayEffects, DisabledEffectsKeepImage) {
  const scene::Scene scene = mirror_scene(0.3f);
  settings::DrawSettings settings = traced(all_effects()), plain = traced({});
  RenderBench bench(scene, kRayEffectsSize, settings);
  const sinks::FrameImage before = drawn_with_rays(scene, plain), with = bench.draw_at_rest();
  EXPECT_LT(share_within(with, before, 4), 0.9);
  EXPECT_FALSE(bench.renderer().can_take(passes::ImageOutputs(), 2)) << "one camera at a time";
  bench.change_settings([](settings::DrawSettings& s) { s.ray_effects.on = {}; });
  EXPECT_EQ(bench.draw_at_rest().rgba8, before.rgba8);
  bench.change_settings([&](settings::DrawSettings& s) { s.ray_effects.on = settings.ray_effects.on; });
  EXPECT_EQ(bench.draw_at_rest().rgba8, with.rgba8) << "no earlier image matters";
}

TEST_F(RayEffects, BackEndsAgreeWithoutHistory) {
  SceneBuilder builder;
  add_bodies(builder);
  scene::Material pane = matte({0.2f, 0.8f, 0.3f});  // drawn forward, over the samples
  pane.alpha_mode = scene::AlphaMode::blend;
  pane.base_color.a = 0.4f;
  builder.mesh_node("pane", builder.box(builder.material(pane), {0.3f, 0.3f, 0.01f}), at({-0.2f, -0.3f, 2}));
  builder.mesh_node("mirror", builder.quad(builder.material(metal(0.25f)), 20), facing_z({0, 0, 0}));
  builder.camera_node("camera", kEye, kLooksAt, 0.6f);
  const scene::Scene scene = builder.build();
  settings::DrawSettings by_query = traced(all_effects()),
                         by_pipeline = traced(all_effects(), settings::RayBackEnd::pipeline);
  by_query.samples = by_pipeline.samples = 4;
  RenderBench bench(scene, kRayEffectsSize, by_query), pipeline_bench(scene, kRayEffectsSize, by_pipeline);
  const sinks::FrameImage alone = bench.draw_at_rest();
  EXPECT_EQ(share_within(alone, pipeline_bench.draw_at_rest(), 1), 1);
  // Other poses and other sizes in between.
  state::PoseState moved(scene);
  const passes::View view = first_camera_view(scene, moved, kRayEffectsSize);
  bench.set_size({64, 48});
  passes::View other = view;
  other.eye_world.x += 0.5f;
  (void)bench.draw(moved, other);
  bench.set_size(kRayEffectsSize);
  EXPECT_EQ(bench.draw(moved, view).rgba8, alone.rgba8);
}

// Glass before luminous tiles: a ball, a tilted slab that absorbs, and a thin pane.
scene::Scene glass_scene() {
  SceneBuilder builder;
  for (int i = 0; i < 12; ++i) {
    for (int k = 0; k < 6; ++k) {
      scene::Material tile = matte(glm::vec3(0));
      tile.specular = 0;
      tile.emissive = (i + k) % 2 ? glm::vec3(0.2f, 0.5f, 0.9f)
                                  : glm::vec3(0.9f, 0.7f - 0.1f * static_cast<float>(k), 0.1f);
      builder.mesh_node(
          "tile", builder.quad(builder.material(tile), 0.25f),
          facing_z({0.5f * static_cast<float>(i) - 2.75f, 0.5f * static_cast<float>(k) - 1.25f, -1.2f}));
    }
  }
  scene::Material glass = matte(glm::vec3(1));
  glass.roughness = 0;
  glass.transmission = 1;
  glass.ior = 1.5f;
  scene::Material pane = glass, slab = glass;
  pane.base_color = {0.9f, 0.5f, 0.9f, 1};
  glass.thickness = slab.thickness = 1;
  slab.attenuation_color = {0.4f, 0.9f, 0.5f};
  slab.attenuation_distance_m = 0.5f;
  builder.mesh_node("ball", builder.sphere(builder.material(glass), 0.5f, 96), at({-1.2f, 0, 0}));
  builder.mesh_node("slab", builder.box(builder.material(slab), {0.4f, 0.5f, 0.15f}),
                    glm::rotate(glm::mat4(1), 0.6f, glm::vec3(0, 1, 0)));
  builder.mesh_node("pane", builder.quad(builder.material(pane), 0.45f), facing_z({1.2f, 0, 0}));
  builder.camera_node("camera", {0, 0.1f, 4}, {0, 0, 0}, 0.35f);
  return builder.build();
}

TEST_F(RayEffects, RefractionAgreesWithPaths) {
  constexpr VkExtent2D kWide{96, 32};
  const scene::Scene scene = glass_scene();
  settings::RayEffects on = reflections();
  on.refraction = true;
  settings::DrawSettings paths = traced({});
  paths.path = settings::PathSettings{.samples_per_pixel = 48, .bounces = 8, .seed = 1};
  const std::vector<glm::dvec3> truth = linear_image(scene, kWide, paths);
  std::vector<glm::dvec3> by_query;
  for (const settings::RayBackEnd back_end : {settings::RayBackEnd::query, settings::RayBackEnd::pipeline}) {
    settings::DrawSettings settings = traced(on, back_end);
    settings.samples = 4;
    const std::vector<glm::dvec3> seen = linear_image(scene, kWide, settings);
    double error = 0, sum = 0, seen_sum = 0, furthest = 0;
    for (size_t i = 0; i < truth.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        error += std::abs(seen[i][c] - truth[i][c]);
        sum += truth[i][c];
        seen_sum += seen[i][c];
        if (!by_query.empty()) furthest = std::max(furthest, std::abs(seen[i][c] - by_query[i][c]));
      }
    }
    RecordProperty("error", std::to_string(error / sum));
    EXPECT_NEAR(seen_sum, sum, 0.02 * sum) << seen_sum / sum;
    EXPECT_LT(error, 0.06 * sum) << error / sum;
    EXPECT_LT(furthest, 2e-3) << "of the other back end";
    by_query = seen;
  }
  // A pixel within the thin pane, whose light comes straight from behind.
  const size_t middle = 16 * 96 + 48 + 27;
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(by_query[middle][c], truth[middle][c], 0.03 * truth[middle][c] + 0.01) << c;
}

TEST_F(RayEffects, UnrefractedGlassIsForward) {
  const scene::Scene scene = glass_scene();
  settings::DrawSettings settings = traced(reflections());
  RenderBench plain(scene, kRayEffectsSize, settings);
  EXPECT_TRUE(plain.renderer().gpu_scene().has_forward_only);
  EXPECT_FALSE(plain.renderer().needs_new_renderer(settings));
  settings.ray_effects.on.refraction = true;
  EXPECT_TRUE(plain.renderer().needs_new_renderer(settings));
  RenderBench refracting(scene, kRayEffectsSize, settings);
  EXPECT_FALSE(refracting.renderer().gpu_scene().has_forward_only);
  EXPECT_FALSE(refracting.renderer().needs_new_renderer(settings));
  // Scenes without glass have nothing to refract.
  const scene::Scene opaque = mirror_scene(0);
  settings.ray_effects.on.reflections = false;
  EXPECT_FALSE(RenderBench(opaque, kRayEffectsSize, settings).renderer().traces_ray_effects());
}

// A narrow view of the floor at a distance from a wall of this height; white, in a white environment.
double open_share(float distance_m, float height_m, float wall_m) {
  SceneBuilder builder;
  const uint32_t white = builder.material(lambert(glm::vec3(1)));
  builder.mesh_node("floor", builder.quad(white, wall_m), glm::mat4(1));
  builder.mesh_node("wall", builder.box(white, {wall_m, height_m / 2, 0.5f}), at({0, height_m / 2, -0.5f}));
  builder.camera_node("camera", {0, 3, distance_m + 1}, {0, 0, distance_m}, 2e-4f);
  settings::DrawSettings settings = traced(ambient_occlusion());
  settings.environment = constant_environment(glm::vec3(1));
  settings.ray_effects.occlusion_rays = 32;  // 512 with the block of 4 x 4 pixels
  settings.ray_effects.occlusion_distance_m = wall_m;
  const std::vector<glm::dvec3> pixels = linear_image(builder.build(), {12, 12}, settings);
  double sum = 0;
  for (int y = 3; y < 9; ++y) {
    for (int x = 3; x < 9; ++x) sum += pixels[12 * y + x].g / 36;
  }
  return sum;
}

TEST_F(RayEffects, OcclusionMatchesFormFactor) {
  // Beside an edge half of the sky is hidden; further off, 1/2 (1 - cos) of it, by the wall's angle.
  EXPECT_NEAR(open_share(0.005f, 400, 500), 0.5, 0.02);
  EXPECT_NEAR(open_share(2, 2, 500), 1 - 0.5 * (1 - std::sqrt(0.5)), 0.02);
  EXPECT_NEAR(open_share(2, 0.01f, 500), 1, 0.005);
}

TEST(RayEffectNames, NamesAreChecked) {
  settings::RayEffects on;
  EXPECT_TRUE(settings::ray_effects_named("bounce,ao,refraction,reflections", on));
  EXPECT_EQ(on, all_effects());
  EXPECT_EQ(settings::describe(on), settings::ray_effect_names());
  EXPECT_TRUE(settings::ray_effects_named("ao", on));
  EXPECT_EQ(on, ambient_occlusion());
  EXPECT_TRUE(settings::ray_effects_named("off", on));
  EXPECT_FALSE(on.any());
  for (const char* wrong : {"", "ao,", ",ao", "mirrors", "ao,off", "AO"})
    EXPECT_FALSE(settings::ray_effects_named(wrong, on)) << wrong;
}

}  // namespace
}  // namespace fire3dv::test
