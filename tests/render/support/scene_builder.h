// Builder of scenes in code: shapes with materials, lights, cameras. Without files a failing image is a fault
// of drawing.
#pragma once

#include <functional>
#include <string>

#include "renderer/scene/model/scene.h"

namespace fire3dv::test {

class SceneBuilder {
 public:
  uint32_t material(const scene::Material& material);
  uint32_t texture(uint32_t width, uint32_t height, bool srgb,
                   const std::function<glm::vec4(float u, float v)>& texel);

  // Adds one primitive of triangles.
  uint32_t mesh(uint32_t material, const std::vector<glm::vec3>& positions,
                const std::vector<scene::VertexAttributes>& attributes, const std::vector<uint32_t>& indices);
  uint32_t sphere(uint32_t material, float radius_m, uint32_t segments = 64);
  uint32_t box(uint32_t material, glm::vec3 half_extent_m);
  uint32_t quad(uint32_t material, float half_extent_m, float uv_repeat = 1);  // in the XZ plane, facing +Y

  // Adds triangles with flat normals.
  uint32_t triangles(uint32_t material, const std::vector<glm::vec3>& positions,
                     const std::vector<uint32_t>& indices);
  // Adds a closed mesh in spherical parameters: theta from pole to pole, phi around.
  uint32_t lathe(uint32_t material, const std::function<glm::vec3(float theta, float phi)>& place,
                 uint32_t segments);

  uint32_t mesh_node(const std::string& name, uint32_t mesh, const glm::mat4& parent_from_node,
                     uint32_t parent = scene::kNone);
  uint32_t light_node(const scene::Light& light, const glm::mat4& parent_from_node);
  uint32_t camera_node(const std::string& name, glm::vec3 eye, glm::vec3 target,
                       float vertical_fov_rad = 0.7f);

  scene::Scene build();

 private:
  uint32_t node(scene::Node node, uint32_t parent);

  scene::Scene scene_;
};

glm::mat4 at(glm::vec3 position);
scene::Material matte(glm::vec3 color);
scene::Light sun(glm::vec3 color, float lux);
glm::mat4 shining_towards(glm::vec3 direction, glm::vec3 from = {});  // transform of a light's node

// Diffuse alone, seen from both sides: its light has a closed form.
inline scene::Material lambert(glm::vec3 albedo) {
  scene::Material material = matte(albedo);
  material.specular = 0;
  material.double_sided = true;
  return material;
}

}  // namespace fire3dv::test
