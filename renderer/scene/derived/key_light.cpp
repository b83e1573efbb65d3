#include "renderer/scene/derived/key_light.h"

#include "renderer/scene/derived/loaded_scene.h"

namespace fire3dv::scene {
namespace {

// Towards the light: upper left of the camera that frames a scene, so that shadows fall to the right and
// back.
constexpr glm::vec3 kToKeyLight{-0.30f, 0.80f, 0.52f};

glm::mat4 pose_shining_from(const glm::vec3& to_light) {
  const glm::vec3 z = glm::normalize(to_light), x = glm::normalize(glm::cross(glm::vec3(0, 1, 0), z));
  glm::mat4 pose(1);
  pose[0] = glm::vec4(x, 0);
  pose[1] = glm::vec4(glm::cross(z, x), 0);
  pose[2] = glm::vec4(z, 0);
  return pose;
}

}  // namespace

void add_key_light(Scene& scene) {
  if (!scene.lights.empty()) return;
  Light light;
  light.name = "key light";
  light.type = LightType::directional;
  light.intensity = kKeyLightLux;
  light.is_default = true;
  scene.lights.push_back(light);
  const uint32_t node = add_node(scene, light.name, kNone, pose_shining_from(kToKeyLight));
  scene.nodes[node].light = 0;
}

void remove_key_light(Scene& scene) {
  if (scene.lights.size() != 1 || !scene.lights[0].is_default) return;
  if (scene.nodes.empty() || scene.nodes.back().light != 0) return;
  scene.nodes.pop_back();
  scene.lights.clear();
}

}  // namespace fire3dv::scene
