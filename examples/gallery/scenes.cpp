#include "examples/gallery/scenes.h"

#include <cmath>
#include <string>
#include <vector>

#include "examples/common/gltf_writer.h"
#include "examples/common/mesh.h"
#include "examples/gallery/stage.h"

namespace gallery {
namespace {

using examples::GltfMaterial;
using examples::Mesh;

// Materials side by side. Metals have measured reflectance at normal incidence (linear) and the roughness of
// hand polish.
SceneFile material_spheres() {
  const GltfMaterial materials[] = {
      {"aluminium", {0.912f, 0.914f, 0.920f}, 1, 0.2f, {}, {}, {}, {}},
      {"gold", {1.000f, 0.782f, 0.344f}, 1, 0.2f, {}, {}, {}, {}},
      {"copper", {0.955f, 0.638f, 0.538f}, 1, 0.25f, {}, {}, {}, {}},
      {"glossy plastic", {0.02f, 0.12f, 0.55f}, 0, 0.08f, {}, {}, {}, {}},
      {"matte plastic", {0.02f, 0.12f, 0.55f}, 0, 0.8f, {}, {}, {}, {}},
  };
  Stage stage;
  stage.ground({0.35f, 0.35f, 0.36f});
  float x = -2;
  for (const GltfMaterial& material : materials) {
    stage.shape(material.name, ball(0.45f), material, standing({x, 0.45f, 0}));
    x += 1;
  }
  stage.light({"sun", "directional", {1, 0.96f, 0.9f}, 2.5f}, {1, 2, 1.2f}, {});
  stage.camera("front", {0, 1.5f, 6.2f}, {0, 0.42f, 0}, 0.36f);
  return stage.finish("material_spheres");
}

// Anti-aliasing test scene: thin bars at many angles before a bright ground, and a ball for curved edges.
SceneFile edges() {
  Stage stage;
  stage.ground({0.75f, 0.74f, 0.72f});
  const GltfMaterial dark{"bar", {0.06f, 0.07f, 0.09f}, 0, 0.6f, {}, {}, {}, {}};
  for (int i = 0; i < 9; ++i) {
    const float turn = -0.7f + 0.175f * static_cast<float>(i);
    stage.shape("bar_" + std::to_string(i), examples::box_mesh({0.6f, 0.012f, 0.012f}, 0.002f), dark,
                standing({0.62f * std::cos(turn), 0.02f, -0.62f * std::sin(turn)}, turn));
  }
  const GltfMaterial red{"ball", {0.7f, 0.12f, 0.08f}, 0, 0.35f, {}, {}, {}, {}};
  stage.shape("ball", ball(0.16f), red, standing({-0.15f, 0.16f, 0}));
  stage.light({"sun", "directional", {1, 1, 1}, 2.5f}, {-0.6f, 2, 0.8f}, {});
  stage.camera("top", {0.42f, 2.2f, 1.6f}, {0.42f, 0, 0.02f}, 0.5f);
  return stage.finish("edges");
}

SceneFile two_lights() {
  Stage stage;
  stage.ground({0.6f, 0.6f, 0.6f});
  const GltfMaterial green{"post", {0.15f, 0.4f, 0.16f}, 0, 0.5f, {}, {}, {}, {}};
  const GltfMaterial gold{"ball", {1.000f, 0.782f, 0.344f}, 1, 0.3f, {}, {}, {}, {}};
  stage.shape("post", examples::box_mesh({0.12f, 0.12f, 0.9f}, 0.02f), green, standing({0, 0.9f, 0}, 0.4f));
  stage.shape("ball", ball(0.4f), gold, standing({1, 0.4f, 0.6f}));
  stage.light({"warm", "spot", {1, 0.8f, 0.6f}, 160, 0.35f, 0.5f}, {3, 4, 1}, {0, 0.2f, 0});
  stage.light({"cool", "point", {0.5f, 0.7f, 1}, 45}, {-3, 3, 1.5f}, {0, 0, 0});
  stage.camera("front", {0.5f, 3.2f, 5}, {0.2f, 0.45f, 0}, 0.6f);
  return stage.finish("two_lights");
}

}  // namespace

std::vector<SceneFile> make_scenes() {
  return {material_spheres(), edges(), two_lights()};
}

}  // namespace gallery
