// Golden image tests of geometry, materials, shadows and textures; the goldens were reviewed by eye.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/model/bounds.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kExtent{320, 240};

class Golden : public ValidationIsSilent {
 protected:
  static void expect_golden(const scene::Scene& scene, const char* name,
                            const settings::DrawSettings& settings = {}) {
    // Both raster paths must match the golden.
    for (const settings::RasterPath path :
         {settings::RasterPath::forward, settings::RasterPath::visibility}) {
      settings::DrawSettings wanted = settings;
      wanted.raster = path;
      SCOPED_TRACE(path == settings::RasterPath::forward ? "forward" : "visibility");
      RenderBench bench(scene, kExtent, wanted);
      EXPECT_TRUE(matches_golden(bench.draw_at_rest(), name, Tolerance::colour()));
    }
  }
};

scene::Material surface(glm::vec3 color, float metallic, float roughness) {
  scene::Material material = matte(color);
  material.metallic = metallic;
  material.roughness = roughness;
  return material;
}

void studio(SceneBuilder& builder) {
  builder.mesh_node("ground", builder.quad(builder.material(matte({0.45f, 0.45f, 0.47f})), 12), glm::mat4(1));
  builder.light_node(sun({1, 0.96f, 0.9f}, 2.5f), shining_towards({-0.5f, -1, -0.4f}));
  scene::Light lamp;
  lamp.type = scene::LightType::point;
  lamp.color = {0.6f, 0.75f, 1};
  lamp.intensity = 25;
  builder.light_node(lamp, at({-3, 3, 3}));
}

// The smallest complete image: one box, one material, one light.
TEST_F(Golden, Box) {
  SceneBuilder builder;
  studio(builder);
  builder.mesh_node("box", builder.box(builder.material(matte({0.8f, 0.25f, 0.2f})), {0.6f, 0.6f, 0.6f}),
                    at({0, 0.6f, 0}) * glm::rotate(glm::mat4(1), 0.5f, glm::vec3(0, 1, 0)));
  builder.camera_node("camera", {1.5f, 2.2f, 4}, {0, 0.5f, 0});
  expect_golden(builder.build(), "box");
}

TEST_F(Golden, MaterialSpheres) {
  SceneBuilder builder;
  studio(builder);
  const scene::Material materials[] = {
      surface({0.912f, 0.914f, 0.920f}, 1, 0.25f),  // aluminium
      surface({1.000f, 0.782f, 0.344f}, 1, 0.25f),  // gold
      surface({0.955f, 0.638f, 0.538f}, 1, 0.35f),  // copper
      surface({0.1f, 0.3f, 0.8f}, 0, 0.15f),        // glossy plastic
      surface({0.1f, 0.3f, 0.8f}, 0, 0.8f),         // matte plastic
  };
  for (int i = 0; i < 5; ++i) {
    builder.mesh_node("ball_" + std::to_string(i), builder.sphere(builder.material(materials[i]), 0.45f),
                      at({static_cast<float>(i - 2), 0.45f, 0}));
  }
  builder.camera_node("camera", {0, 1.6f, 6.5f}, {0, 0.4f, 0}, 0.6f);
  expect_golden(builder.build(), "material_spheres");
}

TEST_F(Golden, TwoLightShadows) {
  SceneBuilder builder;
  builder.mesh_node("ground", builder.quad(builder.material(matte({0.7f, 0.7f, 0.7f})), 12), glm::mat4(1));
  builder.mesh_node("post", builder.box(builder.material(matte({0.3f, 0.6f, 0.3f})), {0.12f, 0.9f, 0.12f}),
                    at({0, 0.9f, 0}));
  builder.mesh_node("ball", builder.sphere(builder.material(matte({0.8f, 0.6f, 0.2f})), 0.4f),
                    at({1, 0.4f, 0.6f}));
  scene::Light warm;
  warm.type = scene::LightType::spot;
  warm.color = {1, 0.8f, 0.6f};
  warm.intensity = 120;
  warm.inner_cone_rad = 0.35f;
  warm.outer_cone_rad = 0.5f;
  builder.light_node(warm, shining_towards({-3, -4, -1}, {3, 4, 1}));
  scene::Light cool;
  cool.type = scene::LightType::point;
  cool.color = {0.5f, 0.7f, 1};
  cool.intensity = 40;
  builder.light_node(cool, at({-3, 3, 1.5f}));
  builder.camera_node("camera", {0.5f, 3.2f, 5}, {0, 0.5f, 0});
  expect_golden(builder.build(), "two_light_shadows");
}

TEST_F(Golden, TexturesOfEveryKind) {
  SceneBuilder builder;
  studio(builder);
  scene::Material material;
  material.metallic = 1;
  material.roughness = 1;
  material.base_color_texture.texture = builder.texture(64, 64, true, [](float u, float v) {
    const bool odd = (static_cast<int>(u * 8) + static_cast<int>(v * 8)) % 2;
    return odd ? glm::vec4(0.9f, 0.8f, 0.3f, 1) : glm::vec4(0.2f, 0.35f, 0.7f, 1);
  });
  material.metallic_roughness_texture.texture = builder.texture(
      64, 64, false, [](float u, float v) { return glm::vec4(0, 0.15f + 0.8f * v, u > 0.5f ? 1 : 0, 1); });
  material.normal_texture.texture = builder.texture(128, 128, false, [](float u, float v) {
    const glm::vec2 cell(glm::fract(u * 8) - 0.5f, glm::fract(v * 8) - 0.5f);
    const glm::vec3 n = glm::length(cell) < 0.35f
                            ? glm::normalize(glm::vec3(cell.x * 0.6f, -cell.y * 0.6f, 1))
                            : glm::vec3(0, 0, 1);
    return glm::vec4(n * 0.5f + 0.5f, 1);
  });
  material.occlusion_texture.texture =
      builder.texture(32, 32, false, [](float, float v) { return glm::vec4(0.3f + 0.7f * v, 0, 0, 1); });
  material.emissive = glm::vec3(1);
  material.emissive_texture.texture = builder.texture(32, 32, true, [](float u, float v) {
    return glm::vec4(
        glm::distance(glm::vec2(u, v), glm::vec2(0.5f)) < 0.1f ? glm::vec3(1, 0.2f, 0.1f) : glm::vec3(0), 1);
  });
  const uint32_t id = builder.material(material);
  builder.mesh_node("box", builder.box(id, {0.7f, 0.7f, 0.7f}),
                    at({-1, 0.7f, 0}) * glm::rotate(glm::mat4(1), 0.6f, glm::vec3(0, 1, 0)));
  builder.mesh_node("ball", builder.sphere(id, 0.7f), at({1, 0.7f, 0}));
  builder.camera_node("camera", {0, 2.2f, 4.5f}, {0, 0.6f, 0});
  settings::DrawSettings settings;
  settings.post.fxaa = false;  // FXAA would spread a difference of one texel to its neighbours
  expect_golden(builder.build(), "textures", settings);
}

// Alpha-masked surfaces let light through their holes. Blended ones show the background, in any order, and
// cast no shadow. Single-sided ones are culled from behind. A mirrored node keeps its front faces.
TEST_F(Golden, AlphaAndSides) {
  SceneBuilder builder;
  studio(builder);
  scene::Material fence = matte({0.9f, 0.7f, 0.3f});
  fence.alpha_mode = scene::AlphaMode::mask;
  fence.double_sided = true;
  fence.base_color_texture.texture = builder.texture(64, 64, true, [](float u, float v) {
    return glm::vec4(1, 1, 1, glm::fract(u * 4) < 0.6f || glm::fract(v * 4) < 0.4f ? 1 : 0);
  });
  const glm::mat4 upright = glm::rotate(glm::mat4(1), 1.5708f, glm::vec3(1, 0, 0));
  builder.mesh_node("fence", builder.quad(builder.material(fence), 0.8f), at({-1.3f, 0.8f, -0.5f}) * upright);
  for (int i = 0; i < 3; ++i) {
    scene::Material glass = matte(i == 0   ? glm::vec3(1, 0.1f, 0.1f)
                                  : i == 1 ? glm::vec3(0.1f, 1, 0.1f)
                                           : glm::vec3(0.1f, 0.1f, 1));
    glass.alpha_mode = scene::AlphaMode::blend;
    glass.double_sided = true;
    glass.base_color.a = 0.5f;
    builder.mesh_node(
        "glass_" + std::to_string(i), builder.quad(builder.material(glass), 0.5f),
        at({0.7f + 0.25f * static_cast<float>(i), 0.6f, -0.4f * static_cast<float>((i + 1) % 3)}) * upright);
  }
  scene::Material plain = matte({0.5f, 0.5f, 0.9f});
  builder.mesh_node(
      "back", builder.quad(builder.material(plain), 0.3f),
      at({-0.2f, 0.4f, 1}) * glm::rotate(glm::mat4(1), -1.5708f, glm::vec3(1, 0, 0)));  // faces away
  builder.mesh_node("mirrored", builder.box(builder.material(plain), {0.25f, 0.25f, 0.25f}),
                    at({-0.2f, 0.25f, 0.2f}) * glm::scale(glm::mat4(1), glm::vec3(-1, 1, 1)));
  builder.camera_node("camera", {0, 1.6f, 4.2f}, {0, 0.5f, 0});
  expect_golden(builder.build(), "alpha_and_sides");
}

TEST_F(Golden, OneSampleNoShadowsNoFxaa) {
  SceneBuilder builder;
  studio(builder);
  builder.mesh_node("ball", builder.sphere(builder.material(surface({0.9f, 0.5f, 0.2f}, 0.5f, 0.4f)), 0.8f),
                    at({0, 0.8f, 0}));
  builder.camera_node("camera", {0, 2, 5}, {0, 0.7f, 0});
  settings::DrawSettings settings;
  settings.samples = 1;
  settings.shadows.method = settings::ShadowMethod::off;
  settings.post.fxaa = false;
  expect_golden(builder.build(), "one_sample_no_shadows", settings);
}

}  // namespace
}  // namespace fire3dv::test
