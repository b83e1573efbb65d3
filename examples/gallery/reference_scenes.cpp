#include "examples/gallery/reference_scenes.h"

#include <array>
#include <string>

#include "examples/common/gltf_writer.h"
#include "examples/common/mesh.h"
#include "examples/gallery/stage.h"

namespace gallery {
namespace {

using examples::GltfMaterial;
using examples::Mesh;
using examples::Vec3;

GltfMaterial lambert(const std::string& name, std::array<float, 3> albedo) {
  GltfMaterial material{name, albedo, 0, 1, {}, {}, {}, {}};
  material.specular = 0.0f;
  return material;
}

GltfMaterial white_metal(float roughness) {
  return {"white metal", {1, 1, 1}, 1, roughness, {}, {}, {}, {}};
}

Vec3 vector(const float (&values)[3]) {
  return {values[0], values[1], values[2]};
}

// The plane fills the image.
Stage plane() {
  Stage stage;
  stage.shape("plane", examples::floor_mesh(6), lambert("matte", {0.5f, 0.4f, 0.3f}), standing({}));
  stage.camera("camera", {0, 2, 2.5f}, {}, 0.7f);
  return stage;
}

SceneFile plane_point() {
  Stage stage = plane();
  stage.light({"bulb", "point", {1, 1, 1}, 10}, {0.5f, 2, -0.3f}, {});
  return stage.finish("plane_point");
}

SceneFile plane_sun() {
  Stage stage = plane();
  stage.light({"sun", "directional", {1, 0.9f, 0.8f}, 3}, {1, 2, 1}, {});
  return stage.finish("plane_sun");
}

SceneFile lit_ball(const std::string& name, const GltfMaterial& material) {
  const BallView view;
  Stage stage;
  stage.shape("ball", ball(view.radius_m), material, standing({}));
  stage.light({"bulb", "point", {1, 1, 1}, view.light_cd}, vector(view.light_m), {});
  stage.camera("camera", vector(view.eye_m), {}, view.vertical_fov_rad);
  return stage.finish(name);
}

// Closed cube of side 1 with a box and a ball, seen from inside.
SceneFile room() {
  Stage stage;
  const Mesh wall = examples::floor_mesh(0.5f);
  const std::array<float, 3> gray{0.7f, 0.7f, 0.7f};
  stage.shape("floor", wall, lambert("gray", gray), facing({0, 0, 0}, {0, 1, 0}));
  stage.shape("ceiling", wall, lambert("gray", gray), facing({0, 1, 0}, {0, -1, 0}));
  stage.shape("back", wall, lambert("gray", gray), facing({0, 0.5f, -0.5f}, {0, 0, 1}));
  stage.shape("front", wall, lambert("gray", gray), facing({0, 0.5f, 0.5f}, {0, 0, -1}));
  stage.shape("left", wall, lambert("red", {0.7f, 0.15f, 0.12f}), facing({-0.5f, 0.5f, 0}, {1, 0, 0}));
  stage.shape("right", wall, lambert("green", {0.15f, 0.6f, 0.15f}), facing({0.5f, 0.5f, 0}, {-1, 0, 0}));
  stage.shape("box", examples::box_mesh({0.13f, 0.13f, 0.28f}, 0.01f), lambert("white", {0.8f, 0.8f, 0.8f}),
              standing({-0.18f, 0.28f, -0.15f}, 0.35f));
  stage.shape("ball", ball(0.16f), lambert("blue", {0.2f, 0.3f, 0.7f}), standing({0.2f, 0.16f, 0.05f}));
  stage.light({"bulb", "point", {1, 0.95f, 0.85f}, 0.5f}, {0.05f, 0.8f, 0.1f}, {});
  stage.camera("camera", {0, 0.5f, 0.48f}, {0, 0.44f, -0.5f}, 1.15f);
  return stage.finish("room");
}

SceneFile environment_balls() {
  Stage stage;
  stage.shape("matte", ball(0.5f), lambert("matte", {0.7f, 0.4f, 0.2f}), standing({-0.52f, 0, 0}));
  stage.shape("metal", ball(0.5f), white_metal(0.2f), standing({0.52f, 0, 0}));
  stage.camera("camera", {0.3f, 0.5f, 3.4f}, {}, 0.5f);
  return stage.finish("environment_balls");
}

// Metals with measured reflectance at normal incidence (linear), and matte surfaces.
SceneFile spheres() {
  const GltfMaterial materials[] = {
      {"aluminium", {0.912f, 0.914f, 0.920f}, 1, 0.1f, {}, {}, {}, {}},
      {"gold", {1.000f, 0.782f, 0.344f}, 1, 0.2f, {}, {}, {}, {}},
      {"copper", {0.955f, 0.638f, 0.538f}, 1, 0.4f, {}, {}, {}, {}},
      lambert("blue", {0.05f, 0.15f, 0.55f}),
  };
  Stage stage;
  stage.shape("ground", examples::floor_mesh(30), lambert("ground", {0.45f, 0.42f, 0.38f}), standing({}));
  float x = -1.35f;
  for (const GltfMaterial& material : materials) {
    stage.shape(material.name, ball(0.42f), material, standing({x, 0.42f, 0}));
    x += 0.9f;
  }
  stage.camera("camera", {0, 1.6f, 5}, {0, 0.36f, 0}, 0.55f);
  return stage.finish("spheres");
}

SceneFile glass() {
  GltfMaterial clear{"glass", {1, 1, 1}, 0, 0, {}, {}, {}, {}};
  clear.transmission = 1;
  clear.thickness_m = 0.9f;
  clear.ior = 1.5f;
  Stage stage;
  const Mesh tile = examples::floor_mesh(0.25f);
  for (int z = -6; z < 5; ++z) {
    for (int x = -6; x < 6; ++x) {
      const bool is_light = (x + z) % 2 == 0;
      const float gray = is_light ? 0.7f : 0.25f;
      stage.shape("tile", tile, lambert(is_light ? "light tile" : "dark tile", {gray, gray, gray}),
                  facing({0.5f * static_cast<float>(x) + 0.25f, 0, 0.5f * static_cast<float>(z)}, {0, 1, 0}));
    }
  }
  stage.shape("glass", ball(0.45f), clear, standing({-0.15f, 0.46f, 0.3f}));
  const Mesh post = examples::box_mesh({0.12f, 0.12f, 0.45f}, 0.02f);
  stage.shape("red post", post, lambert("red", {0.7f, 0.1f, 0.08f}), standing({-0.7f, 0.45f, -0.8f}, 0.4f));
  stage.shape("blue post", post, lambert("blue", {0.1f, 0.2f, 0.65f}), standing({0.55f, 0.45f, -0.6f}, 0.2f));
  stage.shape("metal ball", ball(0.25f), white_metal(0.2f), standing({0.75f, 0.25f, 0.35f}));
  stage.camera("camera", {0.1f, 1.1f, 3.6f}, {0, 0.42f, 0}, 0.5f);
  return stage.finish("glass");
}

}  // namespace

std::vector<SceneFile> make_reference_scenes() {
  return {plane_point(),
          plane_sun(),
          lit_ball("ball_point", lambert("matte", {0.8f, 0.4f, 0.2f})),
          lit_ball("metal_ball", white_metal(BallView{}.metal_roughness)),
          room(),
          environment_balls(),
          spheres(),
          glass()};
}

}  // namespace gallery
