#include "convert/model.h"

#include <numbers>
#include <utility>

#include "base/text.h"

namespace fire3dv::convert {

glm::dquat shining(const glm::dvec3& direction) {
  const glm::dvec3 z = -glm::normalize(direction);
  const glm::dvec3 side = std::abs(z.z) < 0.99 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(side, z));
  return glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z));
}

void add_light_if_none(Model& model) {
  if (!model.lights.empty()) return;
  Light light;
  light.name = "light from above";
  light.type = Light::Type::directional;
  // White surfaces that face the light appear nearly white; the environment adds to it.
  light.intensity = 0.8f * std::numbers::pi_v<float>;
  const glm::dvec3 direction_z_up(-0.5, 0.35, -1);
  const glm::dquat gltf_from_z_up(std::numbers::sqrt2 / 2, -std::numbers::sqrt2 / 2, 0, 0);
  Node node;
  node.name = light.name;
  node.rotation = shining(glm::conjugate(model.gltf_from_model) * (gltf_from_z_up * direction_z_up));
  node.light = model.lights.size();
  model.lights.push_back(std::move(light));
  model.nodes.push_back(std::move(node));
}

std::string sanitize_text(std::string_view text, size_t max_bytes) {
  return printable_text(text, max_bytes);
}

}  // namespace fire3dv::convert
