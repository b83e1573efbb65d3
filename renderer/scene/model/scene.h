// Scene data model: flat arrays with stable indices, independent of Vulkan and the wire format. Conventions
// are glTF's: right-handed, Y up, metres, cameras look along -Z, counter-clockwise winding is front-facing.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <vector>

#include "renderer/scene/model/appearance.h"

namespace fire3dv::scene {

struct Node {
  std::string name;         // as in the file; may be empty or ambiguous
  std::string path;         // names from the root joined by '/'; '~' and '/' in names are escaped as ~0, ~1
  uint32_t parent = kNone;  // parents precede their children
  glm::mat4 parent_from_node{1};  // rest pose
  glm::mat4 world_from_node{1};   // rest pose, derived
  // Components of parent_from_node, which animations replace individually; invalid if given_by_matrix.
  glm::vec3 translation{0};
  glm::quat rotation{1, 0, 0, 0};
  glm::vec3 scale{1};
  bool given_by_matrix = false;
  uint32_t mesh = kNone;
  uint32_t camera = kNone;
  uint32_t light = kNone;
  uint32_t skin = kNone;               // only with a mesh, and only a skin with joints
  uint32_t first_morph_weight = 0;     // into Scene::morph_weights
  uint32_t morph_weight_count = 0;     // the mesh's morph_target_count
  uint32_t semantic = 0;               // semantic class for labels; 0: none
  bool has_instance_vertices = false;  // vertices are replaced at run time, see scene_edits.h
};

// Unpacked vertex attributes, for loaders and generators. The loader generates missing normals, and missing
// tangents for materials with a normal map. Scene stores them packed (vertices.h).
struct VertexAttributes {
  glm::vec4 tangent{1, 0, 0, 1};  // w: sign of the bitangent
  glm::vec4 color{1};             // linear, 0 to 1
  glm::vec2 uv0{0};
  glm::vec2 uv1{0};
  glm::vec3 normal{0, 0, 1};
};

// Packed unit normal and the z component and sign of the tangent; see vertices.h.
struct TangentFrame {
  std::array<int16_t, 3> normal{0, 0, INT16_MAX};
  int16_t tangent_z = 1;
  bool operator==(const TangentFrame&) const = default;
};
using TangentXy = std::array<int16_t, 2>;      // x and y of the tangent
constexpr TangentXy kNoTangent{INT16_MAX, 0};  // default tangent

// Rare vertex attributes.
struct VertexExtras {
  glm::vec2 uv1{0};
  std::array<uint16_t, 4> color{UINT16_MAX, UINT16_MAX, UINT16_MAX, UINT16_MAX};  // linear; UINT16_MAX is 1
  bool operator==(const VertexExtras&) const = default;
};

// Strips, fans and loops are unrolled by the loader.
enum class Topology : uint8_t { triangles, lines, points };

// Four joint influences of a vertex; joints index its skin. The weights of all sets of a vertex add up to 1;
// unused entries have joint 0 and weight 0.
struct Influences {
  std::array<uint16_t, 4> joints{};
  std::array<float, 4> weights{};
};

// Vertex offsets of a morph target at weight 1.
struct MorphDelta {
  glm::vec3 position{0};
  glm::vec3 normal{0};
  // 0 for generated tangents; the deform pass re-orthogonalises them against the normal.
  glm::vec3 tangent{0};
};

// Bounding box of the vertices that a joint influences, in mesh space before skinning. A posed vertex is
// inside the convex hull of its joints' posed boxes.
struct JointBounds {
  uint32_t joint = 0;  // index into the skin
  glm::vec3 bounds_min{0};
  glm::vec3 bounds_max{0};
};

// A list of triangles, lines or points with one material.
struct Primitive {
  Topology topology = Topology::triangles;
  bool lit = true;           // false: points and lines without normals show base colour plus emission
  uint32_t first_index = 0;  // into Scene::indices; indices are relative to first_vertex
  uint32_t index_count = 0;
  uint32_t first_vertex = 0;  // into Scene::positions and the other vertex arrays
  uint32_t vertex_count = 0;
  uint32_t material = 0;
  // Mesh space before skinning; covers all morph weights of rest pose and animations.
  glm::vec3 bounds_min{0};
  glm::vec3 bounds_max{0};
  // Into Scene::influences: the sets of vertex v start at first_influence + v * influence_sets. kNone: the
  // primitive is rigid even if its node has a skin.
  uint32_t first_influence = kNone;
  uint32_t influence_sets = 0;
  uint32_t joint_limit = 0;         // all joint indices of its influences are below
  uint32_t first_joint_bounds = 0;  // into Scene::joint_bounds, sorted by joint
  uint32_t joint_bounds_count = 0;
  // Into Scene::morph_deltas: target t moves vertex v by element first_morph_delta + t * vertex_count + v.
  uint32_t first_morph_delta = kNone;
  uint32_t morph_target_count = 0;
  // Set if the loader duplicated vertices: Scene::vertex_sources[first_vertex_source + v] is the file index
  // of vertex v. kNone: vertices are as in the file.
  uint32_t first_vertex_source = kNone;
  uint32_t file_vertex_count = 0;  // valid with first_vertex_source
  // Into Scene::variant_materials: the file's default material, then that of each variant. kNone: it has no
  // variants.
  uint32_t first_variant_material = kNone;
};

struct Mesh {
  std::string name;
  uint32_t first_primitive = 0;
  uint32_t primitive_count = 0;
  uint32_t morph_target_count = 0;  // the same in all its primitives
  bool unbounded =
      false;  // stands for an infinite surface: it does not count for bounds, framing and exposure
};

struct Joint {
  uint32_t node = 0;
  glm::mat4 joint_from_mesh{1};  // inverse bind matrix
};

// Skinned position: sum of weight * world_from_joint * joint_from_mesh * vertex over the vertex's influences.
// The mesh node's own transform is ignored, as glTF requires.
struct Skin {
  std::string name;
  uint32_t first_joint = 0;  // into Scene::joints
  uint32_t joint_count = 0;  // 0: a joint is outside the default scene
};

enum class AnimationPath : uint8_t { translation, rotation, scale, weights };
enum class Interpolation : uint8_t { step, linear, cubic_spline };

// Key frames of one transform component of one node, or of its morph weights.
struct AnimationChannel {
  uint32_t node = 0;
  AnimationPath path = AnimationPath::translation;
  Interpolation interpolation = Interpolation::linear;
  uint32_t width = 3;       // floats per value: 3, 4 (rotation, xyzw) or the number of morph targets
  uint32_t first_time = 0;  // into Scene::key_times_s, key_count ascending times
  uint32_t key_count = 0;   // 1 or more
  // Into Scene::key_values: one value per key; cubic splines: in-tangent, value, out-tangent.
  uint32_t first_value = 0;
};

struct Animation {
  std::string name;
  uint32_t first_channel = 0;  // into Scene::channels; the last one of a node and path wins
  uint32_t channel_count = 0;
  float duration_s = 0;  // from 0 to the last key
};

struct Scene {
  std::filesystem::path source;
  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Primitive> primitives;
  std::vector<glm::vec3> positions;
  std::vector<TangentFrame> frames;  // packed tangent frame of each vertex
  std::vector<TangentXy> tangents;   // per vertex; empty: no vertex has a tangent
  std::vector<glm::vec2> uvs;        // per vertex: first UV set
  std::vector<VertexExtras> extras;  // per vertex; empty: no vertex has any
  std::vector<uint32_t> indices;
  std::vector<uint32_t> vertex_sources;
  std::vector<Influences> influences;
  std::vector<MorphDelta> morph_deltas;
  std::vector<JointBounds> joint_bounds;
  std::vector<Skin> skins;
  std::vector<Joint> joints;
  std::vector<float> morph_weights;  // rest weights
  std::vector<Animation> animations;
  std::vector<AnimationChannel> channels;
  std::vector<float> key_times_s;
  std::vector<float> key_values;
  std::vector<Material> materials;    // [0] is glTF's default material
  std::vector<std::string> variants;  // names of material variants; see variants.h
  std::vector<uint32_t> variant_materials;
  std::vector<Texture> textures;
  std::vector<Image> images;
  uint32_t sky_texture = kNone;  // background, equirectangular; it lights nothing
  std::vector<Light> lights;
  std::vector<Camera> cameras;
  glm::vec3 view_from{0};                  // direction towards the eye of the default view; 0: the usual one
  glm::vec3 bounds_min{0}, bounds_max{0};  // world, rest pose
  std::vector<std::string> warnings;       // one sentence each: deviations from the file
};

// Nodes with a camera, in node order. Camera names on the command line match node names first, then camera
// names.
inline std::vector<uint32_t> camera_nodes(const Scene& scene) {
  std::vector<uint32_t> nodes;
  for (uint32_t index = 0; index < scene.nodes.size(); ++index) {
    if (scene.nodes[index].camera != kNone) nodes.push_back(index);
  }
  return nodes;
}

// Composes translation, rotation and scale.
inline glm::mat4 parent_from_parts(const glm::vec3& translation, const glm::quat& rotation,
                                   const glm::vec3& scale) {
  const glm::mat4 turn(glm::mat4_cast(glm::normalize(glm::dquat(rotation))));
  return glm::scale(glm::translate(glm::mat4(1), translation) * turn, scale);
}

}  // namespace fire3dv::scene
