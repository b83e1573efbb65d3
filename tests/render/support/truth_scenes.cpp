#include "tests/render/support/truth_scenes.h"

#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {

scene::Scene integrating_sphere(uint32_t segments) {
  SceneBuilder builder;
  builder.mesh_node("sphere", builder.sphere(builder.material(lambert(glm::vec3(0.5f))), 1, segments),
                    glm::mat4(1));
  scene::Light bulb;
  bulb.intensity = 10;
  builder.light_node(bulb, glm::mat4(1));
  builder.camera_node("camera", {0.2f, 0.1f, 0.3f}, {1, 0.2f, -0.3f});
  return builder.build();
}

scene::Scene lit_ball() {
  SceneBuilder builder;
  builder.mesh_node("ball", builder.sphere(builder.material(lambert({0.8f, 0.4f, 0.2f})), 0.5f),
                    at({0, 0.5f, 0}));
  builder.mesh_node("floor", builder.quad(builder.material(lambert(glm::vec3(0.5f))), 3), glm::mat4(1));
  builder.light_node(sun(glm::vec3(1), 4), shining_towards({-0.5f, -1, -0.3f}));
  builder.camera_node("camera", {0.5f, 1.6f, 3}, {0, 0.4f, 0});
  return builder.build();
}

}  // namespace fire3dv::test
