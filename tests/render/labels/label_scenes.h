// Cameras and scenes of the tests of labels.
#pragma once

#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "tests/render/proofs/cast_rays.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {

constexpr VkExtent2D kLabelExtent{96, 72};

inline Eye eye_at(glm::vec3 place, glm::vec3 target) {
  passes::Intrinsics k;
  k.fx_px = 90;
  k.fy_px = 84;
  k.cx_px = 45.25f;
  k.cy_px = 37.5f;
  k.image_px = {kLabelExtent.width, kLabelExtent.height};
  return {k, glm::dmat4(passes::look_at_pose(place, target))};
}

inline passes::View view_through(const Eye& eye) {
  return passes::make_view(eye.intrinsics, glm::mat4(eye.world_from_camera));
}

inline settings::DrawSettings plain(uint32_t samples = 1) {
  settings::DrawSettings settings;
  settings.samples = samples;
  settings.environment_intensity = 0;
  return settings;
}

inline std::vector<Face> resting_faces(const scene::Scene& scene) {
  std::vector<glm::mat4> world_from_node;
  for (const scene::Node& node : scene.nodes) world_from_node.push_back(node.world_from_node);
  return faces_of(scene, world_from_node);
}

// A plate before a wall.
constexpr uint32_t kWall = 0, kPlate = 1;
inline scene::Scene plate_and_wall() {
  SceneBuilder builder;
  scene::Material steel = matte({0.6f, 0.5f, 0.4f});
  steel.metallic = 0.75f;
  steel.roughness = 0.3125f;
  const glm::mat4 upright = glm::rotate(glm::mat4(1), 1.5707963f, glm::vec3(1, 0, 0));
  builder.mesh_node("wall", builder.quad(builder.material(matte({0.25f, 0.5f, 0.75f})), 4), upright);
  builder.mesh_node("plate", builder.box(builder.material(steel), {0.5f, 0.4f, 0.05f}), at({0, 0, 1}));
  builder.mesh_node("ball", builder.box(builder.material(steel), {0.3f, 0.3f, 0.3f}),
                    at({0.45f, 0.2f, 0.5f}));
  builder.mesh_node("beside", builder.box(builder.material(steel), {0.5f, 0.3f, 0.3f}),
                    at({-1.8f, 0.2f, 0.5f}));
  builder.camera_node("camera", {0, 0, 5}, {0, 0, 0});
  scene::Scene scene = builder.build();
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) scene.nodes[n].semantic = 10 + n;
  return scene;
}

}  // namespace fire3dv::test
