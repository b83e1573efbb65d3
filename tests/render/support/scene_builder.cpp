// Test scene construction: meshes, lights, cameras, textures.
#include "tests/render/support/scene_builder.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/passes/view/view.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::test {

uint32_t SceneBuilder::material(const scene::Material& material) {
  if (scene_.materials.empty()) scene_.materials.emplace_back();  // [0] is the default material
  scene_.materials.push_back(material);
  return static_cast<uint32_t>(scene_.materials.size() - 1);
}

uint32_t SceneBuilder::texture(uint32_t width, uint32_t height, bool srgb,
                               const std::function<glm::vec4(float, float)>& texel) {
  scene::Image image;
  image.width = width;
  image.height = height;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const glm::vec4 value = texel((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                    (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
      for (int c = 0; c < 4; ++c) {
        image.rgba8.edit().push_back(
            static_cast<uint8_t>(std::lround(glm::clamp(value[c], 0.0f, 1.0f) * 255.0f)));
      }
    }
  }
  scene_.images.push_back(std::move(image));
  scene_.textures.push_back({static_cast<uint32_t>(scene_.images.size() - 1), {}, srgb});
  return static_cast<uint32_t>(scene_.textures.size() - 1);
}

uint32_t SceneBuilder::mesh(uint32_t material, const std::vector<glm::vec3>& positions,
                            const std::vector<scene::VertexAttributes>& attributes,
                            const std::vector<uint32_t>& indices) {
  scene::Primitive primitive;
  primitive.first_index = static_cast<uint32_t>(scene_.indices.size());
  primitive.index_count = static_cast<uint32_t>(indices.size());
  primitive.first_vertex = static_cast<uint32_t>(scene_.positions.size());
  primitive.vertex_count = static_cast<uint32_t>(positions.size());
  primitive.material = material;
  primitive.bounds_min = primitive.bounds_max = positions.front();
  for (const glm::vec3& p : positions) {
    primitive.bounds_min = glm::min(primitive.bounds_min, p);
    primitive.bounds_max = glm::max(primitive.bounds_max, p);
  }
  scene_.positions.insert(scene_.positions.end(), positions.begin(), positions.end());
  scene::append_attributes(scene_, attributes);
  scene_.indices.insert(scene_.indices.end(), indices.begin(), indices.end());
  scene_.primitives.push_back(primitive);
  scene_.meshes.push_back({"", static_cast<uint32_t>(scene_.primitives.size() - 1), 1});
  return static_cast<uint32_t>(scene_.meshes.size() - 1);
}

uint32_t SceneBuilder::triangles(uint32_t material, const std::vector<glm::vec3>& positions,
                                 const std::vector<uint32_t>& indices) {
  std::vector<glm::vec3> corners;
  std::vector<scene::VertexAttributes> attributes;
  std::vector<uint32_t> order;
  for (size_t i = 0; i < indices.size(); ++i) {
    const uint32_t* triangle = &indices[i - i % 3];
    const glm::vec3 a = positions[triangle[0]], b = positions[triangle[1]], c = positions[triangle[2]];
    const glm::dvec3 n = glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
    corners.push_back(positions[indices[i]]);
    attributes.emplace_back();
    attributes.back().normal = glm::dot(n, n) > 0 ? glm::vec3(glm::normalize(n)) : glm::vec3(0, 1, 0);
    order.push_back(static_cast<uint32_t>(i));
  }
  return mesh(material, corners, attributes, order);
}

uint32_t SceneBuilder::lathe(uint32_t material, const std::function<glm::vec3(float, float)>& place,
                             uint32_t segments) {
  const uint32_t rings = segments / 2;
  std::vector<glm::vec3> positions;
  std::vector<uint32_t> indices;
  for (uint32_t r = 1; r < rings; ++r) {
    for (uint32_t s = 0; s < segments; ++s) {
      positions.push_back(place(static_cast<float>(r) / static_cast<float>(rings) * 3.14159265f,
                                static_cast<float>(s) / static_cast<float>(segments) * 6.28318531f));
    }
  }
  const auto north = static_cast<uint32_t>(positions.size());
  positions.push_back(place(0, 0));
  positions.push_back(place(3.14159265f, 0));
  for (uint32_t s = 0; s < segments; ++s) {
    const uint32_t next = (s + 1) % segments, last = (rings - 2) * segments;
    for (uint32_t i : {north, s, next, north + 1, last + next, last + s}) indices.push_back(i);
    for (uint32_t r = 0; r + 2 < rings; ++r) {
      const uint32_t a = r * segments + s, b = r * segments + next, c = a + segments, d = b + segments;
      for (uint32_t i : {a, c, b, b, c, d}) indices.push_back(i);
    }
  }
  return triangles(material, positions, indices);
}

uint32_t SceneBuilder::sphere(uint32_t material, float radius_m, uint32_t segments) {
  const uint32_t rings = segments / 2;
  std::vector<glm::vec3> positions;
  std::vector<scene::VertexAttributes> attributes;
  std::vector<uint32_t> indices;
  for (uint32_t r = 0; r <= rings; ++r) {
    for (uint32_t s = 0; s <= segments; ++s) {
      const float u = static_cast<float>(s) / static_cast<float>(segments);
      const float v = static_cast<float>(r) / static_cast<float>(rings);
      const float theta = v * 3.14159265f, phi = u * 6.28318531f;
      const glm::vec3 n(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
      positions.push_back(n * radius_m);
      attributes.push_back({.tangent = glm::vec4(std::cos(phi), 0, -std::sin(phi), 1),
                            .uv0 = {u, v},
                            .uv1 = {u, v},
                            .normal = n});
    }
  }
  for (uint32_t r = 0; r < rings; ++r) {
    for (uint32_t s = 0; s < segments; ++s) {
      const uint32_t a = r * (segments + 1) + s, b = a + 1, c = a + segments + 1, d = c + 1;
      for (uint32_t i : {a, c, b, b, c, d}) indices.push_back(i);
    }
  }
  return mesh(material, positions, attributes, indices);
}

uint32_t SceneBuilder::box(uint32_t material, glm::vec3 half) {
  std::vector<glm::vec3> positions;
  std::vector<scene::VertexAttributes> attributes;
  std::vector<uint32_t> indices;
  for (int axis = 0; axis < 3; ++axis) {
    for (float side : {-1.0f, 1.0f}) {
      glm::vec3 n(0), u(0);
      n[axis] = side;
      u[(axis + 1) % 3] = 1;
      const glm::vec3 v = glm::cross(n, u);
      const auto first = static_cast<uint32_t>(positions.size());
      for (const glm::vec2 corner :
           {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
        positions.push_back((n + u * corner.x + v * corner.y) * half);
        const glm::vec2 uv = corner * 0.5f + 0.5f;
        attributes.push_back({.tangent = glm::vec4(u, 1), .uv0 = uv, .uv1 = uv, .normal = n});
      }
      for (uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + i);
    }
  }
  return mesh(material, positions, attributes, indices);
}

uint32_t SceneBuilder::quad(uint32_t material, float half, float uv_repeat) {
  std::vector<glm::vec3> positions;
  std::vector<scene::VertexAttributes> attributes;
  for (const glm::vec2 corner : {glm::vec2(-1, 1), glm::vec2(1, 1), glm::vec2(1, -1), glm::vec2(-1, -1)}) {
    positions.emplace_back(corner.x * half, 0, corner.y * half);
    const glm::vec2 uv = (corner * 0.5f + 0.5f) * uv_repeat;
    attributes.push_back({.tangent = {1, 0, 0, -1}, .uv0 = uv, .uv1 = uv, .normal = {0, 1, 0}});
  }
  return mesh(material, positions, attributes, {0, 1, 2, 0, 2, 3});
}

uint32_t SceneBuilder::node(scene::Node node, uint32_t parent) {
  node.parent = parent;
  node.world_from_node = parent == scene::kNone
                             ? node.parent_from_node
                             : scene_.nodes[parent].world_from_node * node.parent_from_node;
  node.path = parent == scene::kNone ? node.name : scene_.nodes[parent].path + "/" + node.name;
  scene_.nodes.push_back(std::move(node));
  return static_cast<uint32_t>(scene_.nodes.size() - 1);
}

uint32_t SceneBuilder::mesh_node(const std::string& name, uint32_t mesh, const glm::mat4& parent_from_node,
                                 uint32_t parent) {
  scene::Node n;
  n.name = name;
  n.mesh = mesh;
  n.parent_from_node = parent_from_node;
  return node(std::move(n), parent);
}

uint32_t SceneBuilder::light_node(const scene::Light& light, const glm::mat4& parent_from_node) {
  scene_.lights.push_back(light);
  scene::Node n;
  n.name = "light_" + std::to_string(scene_.lights.size());
  n.light = static_cast<uint32_t>(scene_.lights.size() - 1);
  n.parent_from_node = parent_from_node;
  return node(std::move(n), scene::kNone);
}

uint32_t SceneBuilder::camera_node(const std::string& name, glm::vec3 eye, glm::vec3 target,
                                   float vertical_fov_rad) {
  scene::Camera camera;
  camera.name = name;
  camera.vertical_fov_rad = vertical_fov_rad;
  scene_.cameras.push_back(camera);
  scene::Node n;
  n.name = name;
  n.camera = static_cast<uint32_t>(scene_.cameras.size() - 1);
  n.parent_from_node = passes::look_at_pose(eye, target);
  return node(std::move(n), scene::kNone);
}

scene::Scene SceneBuilder::build() {
  if (scene_.materials.empty()) scene_.materials.emplace_back();
  return scene_;
}

glm::mat4 at(glm::vec3 position) {
  return glm::translate(glm::mat4(1), position);
}

scene::Material matte(glm::vec3 color) {
  scene::Material material;
  material.base_color = glm::vec4(color, 1);
  material.metallic = 0;
  material.roughness = 1;
  return material;
}

scene::Light sun(glm::vec3 color, float lux) {
  scene::Light light;
  light.type = scene::LightType::directional;
  light.color = color;
  light.intensity = lux;
  return light;
}

glm::mat4 shining_towards(glm::vec3 direction, glm::vec3 from) {
  return passes::look_at_pose(from, from + direction);
}

}  // namespace fire3dv::test
