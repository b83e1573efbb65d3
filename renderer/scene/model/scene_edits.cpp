#include "renderer/scene/model/scene_edits.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "base/error.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::scene {
namespace {

// Whether one part of all edits differs. Both maps are walked side by side, since most nodes have none.
template <typename Part>
bool differs(const NodeEdits& before, const NodeEdits& after, const Part& part) {
  const NodeEdit nothing;
  auto a = before.begin(), b = after.begin();
  while (a != before.end() || b != after.end()) {
    const bool take_a = a != before.end() && (b == after.end() || a->first <= b->first);
    const bool take_b = b != after.end() && (a == before.end() || b->first <= a->first);
    if (part(take_a ? a->second : nothing) != part(take_b ? b->second : nothing)) return true;
    if (take_a) ++a;
    if (take_b) ++b;
  }
  return false;
}

// Parents stand before their children. Empty: none is.
template <typename Is>
std::vector<bool> with_all_below(const Scene& scene, const NodeEdits& edits, const Is& is) {
  if (std::none_of(edits.begin(), edits.end(), [&](const auto& entry) { return is(entry.second); }))
    return {};
  std::vector<bool> marked(scene.nodes.size(), false);
  for (const auto& [node, edit] : edits) {
    if (node < marked.size() && is(edit)) marked[node] = true;
  }
  for (uint32_t node = 0; node < marked.size(); ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    if (parent != kNone && marked[parent]) marked[node] = true;
  }
  return marked;
}

void hide_all_but(const Scene& scene, uint32_t isolated, std::vector<bool>& hidden) {
  hidden.resize(scene.nodes.size(), false);
  std::vector<bool> shown(scene.nodes.size(), false);
  for (uint32_t node = 0; node < shown.size(); ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    shown[node] = node == isolated || (parent != kNone && shown[parent]);
    if (!shown[node]) hidden[node] = true;
  }
}

}  // namespace

void SceneEdits::set(const Scene& scene, NodeEdits edits, uint32_t isolated) {
  std::vector<bool> hidden =
      with_all_below(scene, edits, [](const NodeEdit& e) { return e.hidden || e.removed; });
  if (isolated < scene.nodes.size()) hide_all_but(scene, isolated, hidden);
  std::vector<bool> removed = with_all_below(scene, edits, [](const NodeEdit& e) { return e.removed; });
  if (hidden != hidden_.is_marked) ++revisions_.visible;
  if (differs(nodes_, edits, [](const NodeEdit& e) { return e.base_color; })) ++revisions_.base_color;
  if (removed != removed_.is_marked || differs(nodes_, edits, [](const NodeEdit& e) { return e.light; }))
    ++revisions_.light;
  if (differs(nodes_, edits, [](const NodeEdit& e) { return e.camera; })) ++revisions_.camera;
  if (differs(nodes_, edits, [](const NodeEdit& e) { return e.vertices; })) ++revisions_.vertices;
  const auto marks = [](std::vector<bool> is_marked) {
    const auto count = static_cast<size_t>(std::count(is_marked.begin(), is_marked.end(), true));
    return Marks{std::move(is_marked), count};
  };
  hidden_ = marks(std::move(hidden));
  removed_ = marks(std::move(removed));
  nodes_ = std::move(edits);
  is_isolated_ = isolated < scene.nodes.size();
  parents_.clear();
}

// Returns true when the mark of a node has changed.
template <typename Is>
bool SceneEdits::mark_below(uint32_t node, Marks& marks, const Is& is) {
  const auto is_marked_itself = [&](uint32_t n) {
    const auto edit = nodes_.find(n);
    return edit != nodes_.end() && is(edit->second);
  };
  const auto is_marked = [&](uint32_t n) { return n < marks.is_marked.size() && marks.is_marked[n]; };
  bool changed = false;
  for (std::vector<uint32_t> open{node}; !open.empty();) {
    const uint32_t next = open.back();
    open.pop_back();
    const uint32_t parent = parents_[next];
    const bool marked = (parent != kNone && is_marked(parent)) || is_marked_itself(next);
    if (marked == is_marked(next)) continue;
    changed = true;
    marks.is_marked.resize(parents_.size(), false);
    marks.is_marked[next] = marked;
    marks.count += marked ? 1 : size_t{0} - 1;
    for (uint32_t child = first_children_[next]; child != kNone; child = next_siblings_[child])
      open.push_back(child);
  }
  if (marks.count == 0) marks.is_marked.clear();
  return changed;
}

void SceneEdits::change(const Scene& scene, NodeChanges changes) {
  FIRE3DV_ASSERT(!is_isolated_);
  if (parents_.size() != scene.nodes.size()) {
    parents_.resize(scene.nodes.size());
    first_children_.assign(parents_.size(), kNone);
    next_siblings_.assign(parents_.size(), kNone);
    for (auto node = static_cast<uint32_t>(parents_.size()); node-- > 0;) {
      parents_[node] = scene.nodes[node].parent;
      if (parents_[node] != kNone)
        next_siblings_[node] = std::exchange(first_children_[parents_[node]], node);
    }
  }
  const NodeEdit nothing;
  std::vector<uint32_t> hidden, removed;
  bool base_color = false, light = false, camera = false, vertices = false;
  for (auto& [node, edit] : changes) {
    if (node >= parents_.size()) continue;
    const auto known = nodes_.find(node);
    const NodeEdit& before = known == nodes_.end() ? nothing : known->second;
    const NodeEdit& after = edit ? *edit : nothing;
    if ((before.hidden || before.removed) != (after.hidden || after.removed)) hidden.push_back(node);
    if (before.removed != after.removed) removed.push_back(node);
    base_color |= before.base_color != after.base_color;
    light |= before.light != after.light;
    camera |= before.camera != after.camera;
    vertices |= before.vertices != after.vertices;
    if (edit) {
      nodes_[node] = std::move(*edit);
    } else if (known != nodes_.end()) {
      nodes_.erase(known);
    }
  }
  // Ancestors come first: a mark that is set is that of the end.
  bool visible = false;
  for (const uint32_t node : hidden)
    visible |= mark_below(node, hidden_, [](const NodeEdit& e) { return e.hidden || e.removed; });
  for (const uint32_t node : removed)
    light |= mark_below(node, removed_, [](const NodeEdit& e) { return e.removed; });
  revisions_.visible += visible;
  revisions_.base_color += base_color;
  revisions_.light += light;
  revisions_.camera += camera;
  revisions_.vertices += vertices;
}

void SceneEdits::set_materials(MaterialEdits edits, MaterialTextureEdits textures) {
  if (edits == materials_ && textures == textures_) return;
  materials_ = std::move(edits);
  textures_ = std::move(textures);
  ++revisions_.materials;
}

MaterialFactors factors_of(const Material& material) {
  return {material.base_color,   material.emissive,           material.metallic,    material.roughness,
          material.normal_scale, material.occlusion_strength, material.alpha_cutoff};
}

Material with_factors(Material material, const MaterialFactors& factors) {
  material.base_color = factors.base_color;
  material.emissive = factors.emissive;
  material.metallic = factors.metallic;
  material.roughness = factors.roughness;
  material.normal_scale = factors.normal_scale;
  material.occlusion_strength = factors.occlusion_strength;
  material.alpha_cutoff = factors.alpha_cutoff;
  return material;
}

Material with_textures(Material material, const MaterialTextures& textures) {
  const auto set = [](TextureRef& texture, uint32_t number) {
    if (number != kNone && texture.texture != kNone) texture.texture = number;
  };
  set(material.base_color_texture, textures.base_color);
  set(material.normal_texture, textures.normal);
  set(material.metallic_roughness_texture, textures.metallic_roughness);
  return material;
}

const Camera* SceneEdits::camera_at(uint32_t node) const {
  const auto edit = nodes_.find(node);
  return edit != nodes_.end() && edit->second.camera ? &*edit->second.camera : nullptr;
}

std::vector<PlacedLight> lights_of(const Scene& scene, const SceneEdits* edits) {
  std::vector<PlacedLight> lights;
  static const NodeEdits kNoEdits;
  const NodeEdits& edited = edits ? edits->nodes() : kNoEdits;
  auto edit = edited.begin();
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    while (edit != edited.end() && edit->first < node) ++edit;
    if (edits && edits->is_removed(node)) continue;
    if (edit != edited.end() && edit->first == node && edit->second.light) {
      lights.push_back({*edit->second.light, node});
    } else if (scene.nodes[node].light != kNone) {
      lights.push_back({scene.lights[scene.nodes[node].light], node});
    }
  }
  return lights;
}

namespace {

uint32_t file_count(const Primitive& primitive) {
  return primitive.first_vertex_source == kNone ? primitive.vertex_count : primitive.file_vertex_count;
}

// File index of a vertex of the primitive.
uint32_t file_vertex(const Scene& scene, const Primitive& primitive, uint32_t vertex) {
  return primitive.first_vertex_source == kNone
             ? vertex
             : scene.vertex_sources[primitive.first_vertex_source + vertex];
}

// True if each corner has its own vertex: the file has no normals, and glTF requires flat ones.
bool is_flat(const Primitive& primitive) {
  return primitive.first_vertex_source != kNone && primitive.vertex_count == primitive.index_count;
}

// Area-weighted vertex normals; flat normals for flat primitives.
std::vector<glm::vec3> normals_of(const Scene& scene, const Primitive& primitive,
                                  std::span<const glm::vec3> positions) {
  const bool flat = is_flat(primitive);
  const auto place = [&](uint32_t vertex) { return flat ? vertex : file_vertex(scene, primitive, vertex); };
  std::vector<glm::vec3> sums(flat ? primitive.vertex_count : file_count(primitive), glm::vec3(0));
  const uint32_t corners = primitive.topology == Topology::triangles ? primitive.index_count / 3 * 3 : 0;
  for (uint32_t i = 0; i < corners; i += 3) {
    const uint32_t* const corner = &scene.indices[primitive.first_index + i];
    const glm::vec3& a = positions[corner[0]];
    const glm::vec3 area = glm::cross(positions[corner[1]] - a, positions[corner[2]] - a);
    for (int c = 0; c < 3; ++c) sums[place(corner[c])] += area;
  }
  std::vector<glm::vec3> normals(primitive.vertex_count);
  for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
    const glm::vec3& sum = sums[place(v)];
    const float length = glm::length(sum);
    // Vertices without a non-degenerate triangle keep the file's normal.
    normals[v] = length > 0 && std::isfinite(length) ? sum / length
                                                     : normal_of(scene.frames[primitive.first_vertex + v]);
  }
  return normals;
}

void find_sphere(PosedVertices& posed) {
  Box box;
  for (const glm::vec3& position : posed.positions) box.add(position);
  if (!box.empty())
    posed.sphere = glm::vec4(0.5f * box.low + 0.5f * box.high, 0.5001f * glm::length(box.high - box.low));
}

std::span<const Primitive> primitives_of(const Scene& scene, const Mesh& mesh) {
  return std::span(scene.primitives).subspan(mesh.first_primitive, mesh.primitive_count);
}

}  // namespace

bool can_replace_vertices(const Node& node) {
  return node.mesh != kNone && node.skin == kNone && node.morph_weight_count == 0;
}

uint64_t file_vertex_count(const Scene& scene, const Mesh& mesh) {
  uint64_t count = 0;
  for (const Primitive& primitive : primitives_of(scene, mesh)) count += file_count(primitive);
  return count;
}

PosedVertices pose_vertices(const Scene& scene, const Mesh& mesh, const ReplacedVertices& replaced) {
  PosedVertices posed;
  size_t first_file_vertex = 0;
  for (const Primitive& primitive : primitives_of(scene, mesh)) {
    const size_t first = posed.positions.size();
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      const size_t from = first_file_vertex + file_vertex(scene, primitive, v);
      posed.positions.push_back(replaced.positions[from]);
      if (replaced.normals.empty()) continue;
      const float length = glm::length(replaced.normals[from]);
      posed.normals.push_back(length > 0 && std::isfinite(length)
                                  ? replaced.normals[from] / length
                                  : normal_of(scene.frames[primitive.first_vertex + v]));
    }
    if (replaced.normals.empty()) {
      const std::vector<glm::vec3> normals =
          normals_of(scene, primitive, std::span(posed.positions).subspan(first));
      posed.normals.insert(posed.normals.end(), normals.begin(), normals.end());
    }
    first_file_vertex += file_count(primitive);
  }
  find_sphere(posed);
  return posed;
}

PosedVertices rest_vertices(const Scene& scene, const Mesh& mesh) {
  PosedVertices posed;
  for (const Primitive& primitive : primitives_of(scene, mesh)) {
    for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + primitive.vertex_count; ++v) {
      posed.positions.push_back(scene.positions[v]);
      posed.normals.push_back(normal_of(scene.frames[v]));
    }
  }
  find_sphere(posed);
  return posed;
}

}  // namespace fire3dv::scene
