// What every description of robots and scenes becomes before it is written as glTF: nodes, meshes, materials.
// Frames and units are the description's own, usually Z up and metres; `gltf_from_model` says how the whole
// stands in glTF's frame (right-handed, Y up, metres). Filled by a reader (readers.h), written by
// write_glb.h. Plain data: no thread-safety of its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/convert/sources.h"

namespace fire3dv::convert {

// An image as a file holds it: PNG or JPEG, else the writer makes a PNG of it.
struct Image {
  std::string name;
  std::vector<std::byte> bytes;
};

struct Material {
  std::string name;
  glm::vec4 base_color{1};  // linear; a: opacity
  float metallic = 0;
  float roughness = 0.5f;
  glm::vec3 emission{0};                   // linear
  std::optional<size_t> base_color_image;  // into Model::images; multiplies base_color
  std::optional<size_t> normal_image;      // tangent space, +Y up
  bool double_sided = true;                // descriptions' meshes are not known to be closed
  bool blended = false;                    // opacity below 1 anywhere
};

// Triangles of one material, counter-clockwise seen from outside. In the frame of the node that shows them.
struct Surface {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // none, or one for each position, of length 1
  std::vector<glm::vec2> uvs;  // none, or one for each position; v grows downwards in the image, as in glTF
  std::vector<uint32_t> indices;  // three for each triangle
  size_t material = 0;            // into Model::materials
  bool operator==(const Surface&) const = default;
};

struct Mesh {
  std::string name;
  std::vector<Surface> surfaces;
};

// Looks along -Z of its node, +Y up, as in glTF.
struct Camera {
  std::string name;
  float vertical_fov_rad = 0.8f;
  float near_m = 0.01f;
  std::optional<float> far_m;
  std::optional<float> aspect;  // width / height
};

// Shines along -Z of its node, as in glTF (KHR_lights_punctual).
struct Light {
  enum class Type { directional, point, spot };
  std::string name;
  Type type = Type::spot;
  glm::vec3 color{1};   // linear
  float intensity = 1;  // candela; lux if directional
  float inner_cone_rad = 0;
  float outer_cone_rad = 0.7853982f;  // half angle
};

struct Node {
  std::string name;              // what streams call it
  std::optional<size_t> parent;  // stands before its children; none: a child of the model's root
  glm::dvec3 translation{0};
  glm::dquat rotation{1, 0, 0, 0};
  glm::dvec3 scale{1};
  std::optional<size_t> mesh, camera, light;
};

struct Model {
  std::string name;                                                           // of the root node
  glm::dquat gltf_from_model{0.7071067811865476, -0.7071067811865476, 0, 0};  // Z up to Y up
  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Material> materials;
  std::vector<Image> images;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  // Faults that cost a part of the picture and not the whole: a sentence each, which names the file and the
  // field.
  std::vector<std::string> warnings;
  // All files that were read or looked for: when none of them has changed, neither has the model.
  Sources sources;
};

}  // namespace fire3dv::convert
