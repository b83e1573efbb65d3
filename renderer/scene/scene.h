// The scene as flat arrays with stable indices. No Vulkan, no wire. Frames follow glTF: right-handed, Y up, metres,
// cameras look along -Z, counter-clockwise front faces. Loaded by load_gltf.h; GPU copies are derived from it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

namespace fire3dv::scene {

constexpr uint32_t kNone = UINT32_MAX;  // "no such index"

struct Node {
  std::string name;               // as in the file; may be empty or shared with others
  std::string path;               // names from the root, joined by '/', with '~' and '/' in names escaped as ~0, ~1
  uint32_t parent = kNone;        // parents stand before their children
  glm::mat4 parent_from_node{1};  // rest pose
  glm::mat4 world_from_node{1};   // rest pose, derived
  uint32_t mesh = kNone;
  uint32_t camera = kNone;
  uint32_t light = kNone;
};

// Attributes beside the position. The loader generates missing normals, and missing tangents where the material has a
// normal map.
struct VertexAttributes {
  glm::vec3 normal{0, 0, 1};
  glm::vec4 tangent{1, 0, 0, 1};  // w: sign of the bitangent
  glm::vec2 uv0{0};
  glm::vec2 uv1{0};
  glm::vec4 color{1};             // linear
};

// The loader unrolls strips, fans and loops.
enum class Topology : uint8_t { triangles, lines, points };

// A list of triangles, lines or points with one material.
struct Primitive {
  Topology topology = Topology::triangles;
  bool lit = true;  // false: lines and points without normals show base colour plus emission
  uint32_t first_index = 0;   // into Scene::indices; values are relative to first_vertex
  uint32_t index_count = 0;
  uint32_t first_vertex = 0;  // into Scene::positions and Scene::attributes
  uint32_t vertex_count = 0;
  uint32_t material = 0;
  glm::vec3 bounds_min{0};
  glm::vec3 bounds_max{0};
};

struct Mesh {
  std::string name;
  uint32_t first_primitive = 0;
  uint32_t primitive_count = 0;
};

struct TextureRef {
  uint32_t texture = kNone;
  uint32_t uv_set = 0;  // 0 or 1
  glm::vec2 uv_offset{0};
  float uv_rotation_rad = 0;
  glm::vec2 uv_scale{1};
};

enum class AlphaMode : uint8_t { opaque, mask, blend };

// glTF 2.0 metallic-roughness. Factors are linear.
struct Material {
  std::string name;
  glm::vec4 base_color{1};
  float metallic = 1;
  float roughness = 1;
  glm::vec3 emissive{0};  // times KHR_materials_emissive_strength
  float normal_scale = 1;
  float occlusion_strength = 1;
  float alpha_cutoff = 0.5f;
  AlphaMode alpha_mode = AlphaMode::opaque;
  bool double_sided = false;
  bool unlit = false;
  TextureRef base_color_texture, metallic_roughness_texture, normal_texture, occlusion_texture, emissive_texture;

  float ior = 1.5f;                // KHR_materials_ior
  float specular = 1;              // KHR_materials_specular
  glm::vec3 specular_color{1};
  float clearcoat = 0;             // KHR_materials_clearcoat
  float clearcoat_roughness = 0;
  float clearcoat_normal_scale = 1;
  glm::vec3 sheen_color{0};        // KHR_materials_sheen
  float sheen_roughness = 0;
  float transmission = 0;          // KHR_materials_transmission, as a thin wall
  TextureRef specular_texture, specular_color_texture;  // A; RGB
  TextureRef clearcoat_texture, clearcoat_roughness_texture, clearcoat_normal_texture;  // R; G; normal
  TextureRef sheen_color_texture, sheen_roughness_texture;  // RGB; A
  TextureRef transmission_texture;  // R
};

// How a material's surfaces are drawn: those that light goes through are blended, whatever their alpha mode.
AlphaMode drawn_alpha_mode(const Material& material);

enum class Wrap : uint8_t { repeat, mirrored_repeat, clamp_to_edge };
struct Sampler {
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  bool nearest_mag = false, nearest_min = false, nearest_mip = false, use_mips = true;
  bool operator==(const Sampler&) const = default;
};

struct Image {
  std::string name;
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba8;  // rows from the top, 4 bytes a pixel
};

// An image as one use of it sees it: an image used both as colour and as data is two textures.
struct Texture {
  uint32_t image = 0;
  Sampler sampler;
  bool srgb = false;
};

enum class LightType : uint8_t { directional, point, spot };
// KHR_lights_punctual. The light shines along its node's -Z.
struct Light {
  std::string name;
  LightType type = LightType::point;
  glm::vec3 color{1};         // linear
  float intensity = 1;        // candela (point, spot) or lux (directional)
  float range_m = 0;          // 0 = infinite
  float radius_m = 0;         // point, spot: of the ball that shines; more than 0 gives soft shadows
  float angular_radius_rad = 0;  // directional: half the angle that the source subtends
  float inner_cone_rad = 0;
  float outer_cone_rad = 0.7853981634f;
};

struct Camera {
  std::string name;
  bool orthographic = false;
  float vertical_fov_rad = 0.8f;
  float aspect = 0;           // 0 = the image's
  float near_m = 0.01f;
  float far_m = 0;            // 0 = infinite
  glm::vec2 half_extent_m{1}; // orthographic
};

struct Scene {
  std::filesystem::path source;
  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Primitive> primitives;
  std::vector<glm::vec3> positions;
  std::vector<VertexAttributes> attributes;
  std::vector<uint32_t> indices;
  std::vector<Material> materials;  // [0] is glTF's default material
  std::vector<Texture> textures;
  std::vector<Image> images;
  std::vector<Light> lights;
  std::vector<Camera> cameras;
  glm::vec3 bounds_min{0}, bounds_max{0};  // world, rest pose
  std::vector<std::string> warnings;       // one sentence each: what of the file is not drawn as it says
};

// The nodes that carry a camera, in node order: camera names on the command line resolve against these, first by node
// name, then by camera name.
std::vector<uint32_t> camera_nodes(const Scene& scene);

}  // namespace fire3dv::scene
