#include "convert/model.h"

#include <cmath>
#include <numbers>
#include <utility>

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

namespace {

struct Character {
  size_t bytes;
  bool fits;  // valid in a name
};

// Decodes the first character.
Character first_of(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {1, first >= 0x20 && first != 0x7f};
  const size_t size = first >= 0xf0 && first < 0xf5 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 0;
  if (size == 0 || first >= 0xf5 || text.size() < size) return {1, false};
  unsigned long code = first & (0xffu >> (size + 1));
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {1, false};
    code = code << 6 | (byte(i) & 0x3f);
  }
  const bool too_long = (size == 3 && code < 0x800) || (size == 4 && (code < 0x10000 || code > 0x10ffff));
  if (too_long || (code >= 0xd800 && code < 0xe000)) return {1, false};
  const bool control = code < 0xa0 || code == 0x2028 || code == 0x2029;
  const bool turns_direction = (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
  return {size, !control && !turns_direction};
}

}  // namespace

std::string sanitize_text(std::string_view text, size_t max_bytes) {
  std::string clean;
  while (!text.empty()) {
    const Character character = first_of(text);
    const std::string_view taken = character.fits ? text.substr(0, character.bytes) : "?";
    if (clean.size() + taken.size() > max_bytes) break;
    clean += taken;
    text.remove_prefix(character.bytes);
  }
  return clean;
}

}  // namespace fire3dv::convert
