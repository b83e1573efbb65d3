// Edits in force on a loaded scene, stored beside it: the scene itself stays as its file has it, so that an
// edit can be undone. Independent of the streams that made them. With the vertices that edits replace.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Of all primitives of a mesh, one after the other, in its frame.
struct ReplacedVertices {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // as many, or none: they follow from the triangles
};

// Of one node. What is not given is as the file says.
struct NodeEdit {
  bool hidden = false;                  // with all below it: neither drawn nor casting shadows
  bool removed = false;                 // with all below it: hidden, and without lights
  std::optional<glm::vec4> base_color;  // linear factor, instead of that of its mesh's materials
  std::optional<Light> light;           // new, or instead of the file's
  std::optional<Camera> camera;         // new, or instead of the file's
  std::shared_ptr<const ReplacedVertices> vertices;
  bool operator==(const NodeEdit&) const = default;
};
using NodeEdits = std::map<uint32_t, NodeEdit>;

// Of one material, instead of the file's: what its textures are multiplied with and compared to. Textures and
// modes stay.
struct MaterialFactors {
  glm::vec4 base_color{1};
  glm::vec3 emissive{0};
  float metallic = 1, roughness = 1;
  float normal_scale = 1, occlusion_strength = 1, alpha_cutoff = 0.5f;
  bool operator==(const MaterialFactors&) const = default;
};
using MaterialEdits = std::map<uint32_t, MaterialFactors>;  // by the material's number
// Textures of one material, instead of the file's: numbers of textures of the scene. kNone: the file's. Only
// for kinds of which the material has one.
struct MaterialTextures {
  uint32_t base_color = kNone, normal = kNone, metallic_roughness = kNone;
  bool operator==(const MaterialTextures&) const = default;
};
using MaterialTextureEdits = std::map<uint32_t, MaterialTextures>;  // by the material's number
MaterialFactors factors_of(const Material& material);
Material with_factors(Material material, const MaterialFactors& factors);
Material with_textures(Material material, const MaterialTextures& textures);

// Which of it is newer than what somebody has seen. Each only ever rises.
struct EditRevisions {
  uint64_t visible = 0, base_color = 0, light = 0, camera = 0, vertices = 0, materials = 0;
  bool operator==(const EditRevisions&) const = default;
};

struct PlacedLight {
  Light light;
  uint32_t node = 0;
};

class SceneEdits {
 public:
  // All that is edited from now on. The scene's nodes are those that the keys speak of. isolated: all that is
  // neither this node nor below it is hidden; kNone: nothing is for that.
  void set(const Scene& scene, NodeEdits edits, uint32_t isolated = kNone);
  // As set() with these nodes' edits changed, in ascending order; nothing: the node is not edited any more.
  // Costs these nodes and what lies below those that are hidden or shown. For the scene of the last set(),
  // without an isolated node.
  using NodeChanges = std::vector<std::pair<uint32_t, std::optional<NodeEdit>>>;
  void change(const Scene& scene, NodeChanges changes);
  // Those of materials, all that are edited from now on. A number that the scene does not have changes
  // nothing.
  void set_materials(MaterialEdits edits, MaterialTextureEdits textures = {});

  const NodeEdits& nodes() const { return nodes_; }
  const MaterialEdits& materials() const { return materials_; }
  const MaterialTextureEdits& textures() const { return textures_; }
  const EditRevisions& revisions() const { return revisions_; }
  // By itself, by a node above it, or because another one is isolated.
  bool is_hidden(uint32_t node) const { return node < hidden().size() && hidden()[node]; }
  bool is_removed(uint32_t node) const {
    return node < removed_.is_marked.size() && removed_.is_marked[node];
  }
  // Of each node; empty: none is.
  const std::vector<bool>& hidden() const { return hidden_.is_marked; }
  const Camera* camera_at(uint32_t node) const;  // null: as the file says

 private:
  // Of nodes with all below them. Empty: none is.
  struct Marks {
    std::vector<bool> is_marked;
    size_t count = 0;
  };
  template <typename Is>
  bool mark_below(uint32_t node, Marks& marks, const Is& is);

  NodeEdits nodes_;
  MaterialEdits materials_;
  MaterialTextureEdits textures_;
  Marks hidden_, removed_;
  bool is_isolated_ = false;
  std::vector<uint32_t> parents_, first_children_, next_siblings_;  // of the scene; made when they are needed
  EditRevisions revisions_;
};

// In node order. edits: null where there are none.
std::vector<PlacedLight> lights_of(const Scene& scene, const SceneEdits* edits);

// True if the node has a mesh that neither a skin nor morph targets deform.
bool can_replace_vertices(const Node& node);

// Number of vertices of all drawn primitives in the file; the loader may have duplicated some.
uint64_t file_vertex_count(const Scene& scene, const Mesh& mesh);

// Posed scene vertices, primitive by primitive.
struct PosedVertices {
  std::vector<glm::vec3> positions, normals;
  glm::vec4 sphere{0};  // bounding sphere: centre and radius
};
// Positions of the edit, with its normals or recomputed ones. replaced: has file_vertex_count() vertices.
PosedVertices pose_vertices(const Scene& scene, const Mesh& mesh, const ReplacedVertices& replaced);
// Vertices as in the file.
PosedVertices rest_vertices(const Scene& scene, const Mesh& mesh);

}  // namespace fire3dv::scene
