#include "renderer/scene/derived/loaded_scene.h"

#include "base/text.h"
#include "base/vectors.h"
#include "renderer/scene/model/scene_fields.h"

namespace fire3dv::scene {

bool needs_levels(const Scene& scene, Levels levels) {
  if (levels != Levels::automatic_levels) return levels == Levels::all;
  constexpr uint64_t kFewestDrawn = 20'000'000, kMaxInFile = 1'000'000;
  const auto triangles_of = [&](const Mesh& mesh) {
    uint64_t triangles = 0;
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      if (scene.primitives[p].topology == Topology::triangles)
        triangles += scene.primitives[p].index_count / 3;
    }
    return triangles;
  };
  uint64_t drawn = 0, in_file = 0;
  std::vector<uint64_t> of_mesh;
  for (const Mesh& mesh : scene.meshes) in_file += of_mesh.emplace_back(triangles_of(mesh));
  for (const Node& node : scene.nodes) drawn += node.mesh == kNone ? 0 : of_mesh[node.mesh];
  return drawn >= kFewestDrawn && in_file <= kMaxInFile;
}

Derived derive(const Scene& scene, Levels levels, const LoadProgress& progress) {
  const bool with_levels = needs_levels(scene, levels);
  Derived derived;
  derived.clusters = cut_clusters(scene, [&](size_t done) {
    if (progress) progress("clusters", done, scene.primitives.size());
  });
  derived.casters = classify_casters(scene);
  if (with_levels) {
    add_cluster_levels(scene, derived.clusters, [&](size_t done, size_t total) {
      if (progress) progress("levels of detail", done, total);
    });
  }
  derived.has_levels = with_levels;
  return derived;
}

namespace {

// Instances of acceleration structures name nodes by 24 bits; all other indices have 32, and kNone is not
// one.
constexpr uint64_t kMaxNodes = (uint64_t{1} << 24) - 1;

template <typename T>
uint32_t size_of(const std::vector<T>& values) {
  return static_cast<uint32_t>(values.size());
}

void move(uint32_t& index, uint32_t by) {
  if (index != kNone) index += by;
}

template <typename T>
bool fits(const std::vector<T>& a, const std::vector<T>& b, uint64_t most = kNone) {
  return uint64_t{a.size()} + b.size() <= most;
}

Result<void> check_room(const LoadedScene& to, const LoadedScene& asset) {
  const Scene& a = to.scene;
  const Scene& b = asset.scene;
  const ClusteredGeometry& c = to.derived.clusters;
  const ClusteredGeometry& d = asset.derived.clusters;
  if (!fits(a.nodes, b.nodes, kMaxNodes))
    return Error{"the scene would have more than " + std::to_string(kMaxNodes) + " nodes"};
  const bool room = fits(a.positions, b.positions) && fits(a.indices, b.indices) &&
                    fits(a.influences, b.influences) && fits(a.morph_deltas, b.morph_deltas) &&
                    fits(a.joint_bounds, b.joint_bounds) && fits(a.joints, b.joints) &&
                    fits(a.morph_weights, b.morph_weights) && fits(a.vertex_sources, b.vertex_sources) &&
                    fits(a.primitives, b.primitives) && fits(a.materials, b.materials) &&
                    fits(c.source_vertices, d.source_vertices) &&
                    fits(c.triangles, d.triangles, kMaxRayBoxTriangles) &&
                    index_count(c) + index_count(d) <= kNone && fits(c.clusters, d.clusters);
  if (!room) return Error{"the scene would have more vertices or triangles than can be numbered"};
  return {};
}

void add_nodes(Scene& to, const Scene& from, uint32_t parent) {
  const uint32_t first = size_of(to.nodes);
  for (Node node : from.nodes) {
    node.name.clear();
    if (!node.path.empty()) node.path = to.nodes[parent].path + "/" + node.path;
    node.parent = node.parent == kNone ? parent : node.parent + first;
    node.world_from_node = to.nodes[node.parent].world_from_node * node.parent_from_node;
    move(node.mesh, size_of(to.meshes));
    move(node.camera, size_of(to.cameras));
    move(node.light, size_of(to.lights));
    move(node.skin, size_of(to.skins));
    node.first_morph_weight += size_of(to.morph_weights);
    to.nodes.push_back(std::move(node));
  }
}

// Of what a scene has of all its vertices or of none.
template <typename T>
void append_vertices(std::vector<T>& to_values, const std::vector<T>& from_values, const Scene& to,
                     const Scene& from, const T& without) {
  if (to_values.empty() && from_values.empty()) return;
  to_values.resize(to.positions.size(), without);
  append_all(to_values, from_values);
  to_values.resize(to.positions.size() + from.positions.size(), without);
}

void add_geometry(Scene& to, const Scene& from) {
  for (Mesh mesh : from.meshes) {
    mesh.first_primitive += size_of(to.primitives);
    to.meshes.push_back(std::move(mesh));
  }
  for (Primitive p : from.primitives) {
    p.first_index += size_of(to.indices);
    p.first_vertex += size_of(to.positions);
    p.material += size_of(to.materials);
    p.first_variant_material = kNone;  // a scene has one list of variants; the asset's material stays
    move(p.first_influence, size_of(to.influences));
    p.first_joint_bounds += size_of(to.joint_bounds);
    move(p.first_morph_delta, size_of(to.morph_deltas));
    move(p.first_vertex_source, size_of(to.vertex_sources));
    to.primitives.push_back(p);
  }
  append_vertices(to.tangents, from.tangents, to, from, kNoTangent);
  append_vertices(to.extras, from.extras, to, from, VertexExtras());
  append_all(to.positions, from.positions);
  append_all(to.frames, from.frames);
  append_all(to.uvs, from.uvs);
  append_all(to.indices, from.indices);
  append_all(to.vertex_sources, from.vertex_sources);
  append_all(to.influences, from.influences);
  append_all(to.morph_deltas, from.morph_deltas);
  append_all(to.joint_bounds, from.joint_bounds);
  append_all(to.morph_weights, from.morph_weights);
}

void add_skins(Scene& to, const Scene& from, uint32_t first_node) {
  for (Skin skin : from.skins) {
    skin.first_joint += size_of(to.joints);
    to.skins.push_back(std::move(skin));
  }
  for (Joint joint : from.joints) {
    joint.node += first_node;
    to.joints.push_back(joint);
  }
}

void add_looks(Scene& to, const Scene& from) {
  for (Material material : from.materials) {
    visit_textures(material, [&](TextureRef& texture) { move(texture.texture, size_of(to.textures)); });
    to.materials.push_back(std::move(material));
  }
  for (Texture texture : from.textures) {
    texture.image += size_of(to.images);
    to.textures.push_back(texture);
  }
  append_all(to.images, from.images);
  append_all(to.lights, from.lights);
  append_all(to.cameras, from.cameras);
}

void add_derived(Derived& to, const Derived& from, uint32_t first_vertex) {
  ClusteredGeometry& a = to.clusters;
  const ClusteredGeometry& b = from.clusters;
  const auto first_index = static_cast<uint32_t>(index_count(a));
  for (ClusteredPrimitive p : b.primitives) {
    p.first_index += first_index;
    p.first_vertex += size_of(a.source_vertices);
    p.first_cluster += size_of(a.clusters);
    p.first_level_cluster += size_of(a.clusters);
    p.first_ray_box += size_of(a.ray_boxes);
    a.primitives.push_back(p);
  }
  for (Cluster cluster : b.clusters) {
    cluster.first_vertex += size_of(a.source_vertices);
    cluster.first_triangle += size_of(a.triangles);
    move(cluster.made_by, size_of(a.level_groups));
    move(cluster.merged_by, size_of(a.level_groups));
    a.clusters.push_back(cluster);
  }
  for (RayAabb box : b.ray_boxes) {
    box.first_vertex += size_of(a.source_vertices);
    box.triangles += size_of(a.triangles);
    a.ray_boxes.push_back(box);
  }
  for (const uint32_t vertex : b.source_vertices) a.source_vertices.push_back(vertex + first_vertex);
  append_all(a.level_groups, b.level_groups);
  append_all(a.triangles, b.triangles);
  append_all(to.casters, from.casters);
  to.has_levels |= from.has_levels;
}

}  // namespace

uint32_t add_node(Scene& scene, const std::string& name, uint32_t parent, const glm::mat4& parent_from_node) {
  Node node;
  node.name = name;
  node.path = path_part(name);
  node.parent = parent;
  node.parent_from_node = node.world_from_node = parent_from_node;
  node.given_by_matrix = true;
  if (parent != kNone) {
    node.path = scene.nodes[parent].path + "/" + node.path;
    node.world_from_node = scene.nodes[parent].world_from_node * parent_from_node;
  }
  scene.nodes.push_back(std::move(node));
  return static_cast<uint32_t>(scene.nodes.size() - 1);
}

Result<void> add_below(LoadedScene& to, const LoadedScene& asset, uint32_t parent) {
  if (auto room = check_room(to, asset); !room) return room;
  // Indices are moved by what is there before: each step comes before what it counts grows.
  const uint32_t first_node = size_of(to.scene.nodes), first_vertex = size_of(to.scene.positions);
  add_nodes(to.scene, asset.scene, parent);
  add_skins(to.scene, asset.scene, first_node);
  add_geometry(to.scene, asset.scene);
  add_looks(to.scene, asset.scene);
  add_derived(to.derived, asset.derived, first_vertex);
  return {};
}

}  // namespace fire3dv::scene
