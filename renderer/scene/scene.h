// The scene as flat arrays with stable indices. No Vulkan, no wire. Frames follow glTF: right-handed, Y up,
// metres, cameras look along -Z, counter-clockwise front faces. Loaded by load_gltf.h; GPU copies are derived
// from it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <vector>

namespace fire3dv::scene {

constexpr uint32_t kNone = UINT32_MAX;  // "no such index"

struct Node {
  std::string name;         // as in the file; may be empty or shared with others
  std::string path;         // names from the root, joined by '/', with '~' and '/' in names escaped as ~0, ~1
  uint32_t parent = kNone;  // parents stand before their children
  glm::mat4 parent_from_node{1};  // rest pose
  glm::mat4 world_from_node{1};   // rest pose, derived
  // The parts of parent_from_node, which animations replace one by one; without meaning for a node given by a
  // matrix.
  glm::vec3 translation{0};
  glm::quat rotation{1, 0, 0, 0};
  glm::vec3 scale{1};
  bool given_by_matrix = false;
  uint32_t mesh = kNone;
  uint32_t camera = kNone;
  uint32_t light = kNone;
  uint32_t skin = kNone;            // only with a mesh, and only a skin that has joints
  uint32_t first_morph_weight = 0;  // into Scene::morph_weights
  uint32_t morph_weight_count = 0;  // the mesh's morph_target_count
  uint32_t semantic = 0;            // class of what it shows, for labels; 0: none is given
  bool own_vertices = false;        // its mesh's vertices are replaced while it is shown, see scene_edits.h
};

// What a vertex has beside its position, as files say it and as whoever makes vertices writes it. The loader
// generates missing normals, and missing tangents where the material has a normal map. A scene keeps it
// packed: see packed_vertices.h.
struct VertexAttributes {
  glm::vec4 tangent{1, 0, 0, 1};  // w: sign of the bitangent
  glm::vec4 color{1};             // linear, 0 to 1
  glm::vec2 uv0{0};
  glm::vec2 uv1{0};
  glm::vec3 normal{0, 0, 1};
};

// A unit normal and what it leaves room for of a unit tangent, as packed_vertices.h has them.
struct TangentFrame {
  std::array<int16_t, 3> normal{0, 0, INT16_MAX};
  int16_t tangent_z = 1;
  bool operator==(const TangentFrame&) const = default;
};
using TangentXy = std::array<int16_t, 2>;      // the rest of it
constexpr TangentXy kNoTangent{INT16_MAX, 0};  // of a vertex without one

// What few files have.
struct VertexExtras {
  glm::vec2 uv1{0};
  std::array<uint16_t, 4> color{UINT16_MAX, UINT16_MAX, UINT16_MAX, UINT16_MAX};  // linear; the most is 1
  bool operator==(const VertexExtras&) const = default;
};

// The loader unrolls strips, fans and loops.
enum class Topology : uint8_t { triangles, lines, points };

// Four of the joints that move a vertex, as indices into its skin. The weights of all sets of a vertex add up
// to 1; an unused place has joint 0 and weight 0.
struct Influences {
  std::array<uint16_t, 4> joints{};
  std::array<float, 4> weights{};
};

// What a morph target of weight 1 adds to a vertex.
struct MorphDelta {
  glm::vec3 position{0};
  glm::vec3 normal{0};
  glm::vec3 tangent{
      0};  // none for generated tangents: whoever deforms makes those perpendicular to the normal again
};

// The box around all vertices of a primitive that a joint moves, in the mesh's frame before skinning. A posed
// vertex lies in the hull of its joints' posed boxes.
struct JointBounds {
  uint32_t joint = 0;  // index into the skin
  glm::vec3 bounds_min{0};
  glm::vec3 bounds_max{0};
};

// A list of triangles, lines or points with one material.
struct Primitive {
  Topology topology = Topology::triangles;
  bool lit = true;           // false: lines and points without normals show base colour plus emission
  uint32_t first_index = 0;  // into Scene::indices; values are relative to first_vertex
  uint32_t index_count = 0;
  uint32_t first_vertex = 0;  // into Scene::positions and what else there is of vertices
  uint32_t vertex_count = 0;
  uint32_t material = 0;
  // In the mesh's frame, before skinning, with every weight that morph targets have at rest or in an
  // animation.
  glm::vec3 bounds_min{0};
  glm::vec3 bounds_max{0};
  // Into Scene::influences: vertex v has the influence_sets sets from first_influence + v * influence_sets.
  // kNone: the primitive moves with its node, whatever skin that has.
  uint32_t first_influence = kNone;
  uint32_t influence_sets = 0;
  uint32_t joint_limit = 0;         // every joint of its influences is below
  uint32_t first_joint_bounds = 0;  // into Scene::joint_bounds, by rising joint
  uint32_t joint_bounds_count = 0;
  // Into Scene::morph_deltas: target t moves vertex v by first_morph_delta + t * vertex_count + v.
  uint32_t first_morph_delta = kNone;
  uint32_t morph_target_count = 0;
  // Where the loader has doubled vertices: the file's number of vertex v is at first_vertex_source + v of
  // Scene::vertex_sources. kNone: vertices are as in the file.
  uint32_t first_vertex_source = kNone;
  uint32_t file_vertex_count = 0;  // only where they are not
};

struct Mesh {
  std::string name;
  uint32_t first_primitive = 0;
  uint32_t primitive_count = 0;
  uint32_t morph_target_count = 0;  // of each of its primitives
};

struct Joint {
  uint32_t node = 0;
  glm::mat4 joint_from_mesh{1};  // inverse bind matrix
};

// A vertex of a skinned mesh is shown at the sum of weight * world_from_joint * joint_from_mesh * vertex over
// its influences: the transform of the mesh's own node has no part in it.
struct Skin {
  std::string name;
  uint32_t first_joint = 0;  // into Scene::joints
  uint32_t joint_count = 0;  // 0: a joint is not part of the shown scene
};

enum class AnimationPath : uint8_t { translation, rotation, scale, weights };
enum class Interpolation : uint8_t { step, linear, cubic_spline };

// One part of one node's transform, or its morph weights, over time.
struct AnimationChannel {
  uint32_t node = 0;
  AnimationPath path = AnimationPath::translation;
  Interpolation interpolation = Interpolation::linear;
  uint32_t width = 3;       // floats a value: 3, 4 (rotation, xyzw) or the number of morph targets
  uint32_t first_time = 0;  // into Scene::key_times_s, key_count times that rise
  uint32_t key_count = 0;   // 1 or more
  uint32_t first_value =
      0;  // into Scene::key_values: a value a key; cubic splines: in-tangent, value, out-tangent
};

struct Animation {
  std::string name;
  uint32_t first_channel = 0;  // into Scene::channels; several of one node and path: the last one counts
  uint32_t channel_count = 0;
  float duration_s = 0;  // from 0 to the last key
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
  TextureRef base_color_texture, metallic_roughness_texture, normal_texture, occlusion_texture,
      emissive_texture;

  float ior = 1.5f;    // KHR_materials_ior
  float specular = 1;  // KHR_materials_specular
  glm::vec3 specular_color{1};
  float clearcoat = 0;  // KHR_materials_clearcoat
  float clearcoat_roughness = 0;
  float clearcoat_normal_scale = 1;
  glm::vec3 sheen_color{0};  // KHR_materials_sheen
  float sheen_roughness = 0;
  float transmission = 0;                               // KHR_materials_transmission, as a thin wall
  TextureRef specular_texture, specular_color_texture;  // A; RGB
  TextureRef clearcoat_texture, clearcoat_roughness_texture, clearcoat_normal_texture;  // R; G; normal
  TextureRef sheen_color_texture, sheen_roughness_texture;                              // RGB; A
  TextureRef transmission_texture;                                                      // R
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
  glm::vec3 color{1};            // linear
  float intensity = 1;           // candela (point, spot) or lux (directional)
  float range_m = 0;             // 0 = infinite
  float radius_m = 0;            // point, spot: of the ball that shines; more than 0 gives soft shadows
  float angular_radius_rad = 0;  // directional: half the angle that the source subtends
  float inner_cone_rad = 0;
  float outer_cone_rad = 0.7853981634f;
  bool casts_shadow = true;
  bool operator==(const Light&) const = default;
};

struct Camera {
  std::string name;
  bool orthographic = false;
  float vertical_fov_rad = 0.8f;
  float aspect = 0;  // 0 = the image's
  float near_m = 0.01f;
  float far_m = 0;             // 0 = infinite
  glm::vec2 half_extent_m{1};  // orthographic
  float exposure = 0;          // factor on linear colour; 0 = as the settings say
  bool operator==(const Camera&) const = default;
};

struct Scene {
  std::filesystem::path source;
  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Primitive> primitives;
  std::vector<glm::vec3> positions;
  std::vector<TangentFrame> frames;  // [vertex]
  std::vector<TangentXy> tangents;   // [vertex], or empty: no vertex has one
  std::vector<glm::vec2> uvs;        // [vertex]: the first set
  std::vector<VertexExtras> extras;  // [vertex], or empty: no vertex has any
  std::vector<uint32_t> indices;
  std::vector<uint32_t> vertex_sources;
  std::vector<Influences> influences;
  std::vector<MorphDelta> morph_deltas;
  std::vector<JointBounds> joint_bounds;
  std::vector<Skin> skins;
  std::vector<Joint> joints;
  std::vector<float> morph_weights;  // at rest
  std::vector<Animation> animations;
  std::vector<AnimationChannel> channels;
  std::vector<float> key_times_s;
  std::vector<float> key_values;
  std::vector<Material> materials;  // [0] is glTF's default material
  std::vector<Texture> textures;
  std::vector<Image> images;
  std::vector<Light> lights;
  std::vector<Camera> cameras;
  glm::vec3 bounds_min{0}, bounds_max{0};  // world, rest pose
  std::vector<std::string> warnings;       // one sentence each: what of the file is not drawn as it says
};

// The nodes that carry a camera, in node order: camera names on the command line resolve against these, first
// by node name, then by camera name.
std::vector<uint32_t> camera_nodes(const Scene& scene);

// A node's transform from its parts.
glm::mat4 parent_from_parts(const glm::vec3& translation, const glm::quat& rotation, const glm::vec3& scale);

}  // namespace fire3dv::scene
