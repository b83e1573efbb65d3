#include "renderer/scene/model/scene.h"

#include <glm/gtc/matrix_transform.hpp>

namespace fire3dv::scene {

AlphaMode drawn_alpha_mode(const Material& material) {
  return material.transmission > 0 && !material.unlit ? AlphaMode::blend : material.alpha_mode;
}

std::vector<uint32_t> camera_nodes(const Scene& scene) {
  std::vector<uint32_t> nodes;
  for (uint32_t index = 0; index < scene.nodes.size(); ++index) {
    if (scene.nodes[index].camera != kNone) nodes.push_back(index);
  }
  return nodes;
}

glm::mat4 parent_from_parts(const glm::vec3& translation, const glm::quat& rotation, const glm::vec3& scale) {
  const glm::mat4 turn(glm::mat4_cast(glm::normalize(glm::dquat(rotation))));
  return glm::scale(glm::translate(glm::mat4(1), translation) * turn, scale);
}

}  // namespace fire3dv::scene
