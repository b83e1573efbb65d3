#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "renderer/scene/gltf/gltf_accessors.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/gltf/gltf_parts.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {
namespace {

// EXT_mesh_gpu_instancing: reads instance transforms of a node's mesh, and counts and limits the instances
// over the whole file.
class Instancing {
 public:
  Instancing(const GltfDocument& document, const LoadLimits& limits) : document_(document), limits_(limits) {}

  // Transform from each instance to the node's frame; nullopt if the node has no such extension.
  Result<std::optional<std::vector<glm::mat4>>> node_from_instances(const tinygltf::Node& source,
                                                                    const std::string& where);

 private:
  const GltfDocument& document_;
  const LoadLimits& limits_;
  size_t instances_ = 0;
};

// Limit per file: each instance becomes a node, and nodes may share accessors.
constexpr size_t kMaxInstances = size_t{1} << 20;

struct Parts {
  glm::vec3 translation{0};
  glm::vec4 rotation{0, 0, 0, 1};  // x, y, z, w as in the file
  glm::vec3 scale{1};
};
constexpr size_t kPartFloats = sizeof(Parts) / sizeof(float);
static_assert(sizeof(Parts) == kPartFloats * sizeof(float));

// Rotations are floats or normalised integers; translations and scales are floats.
Result<void> check_type(const tinygltf::Accessor& accessor, bool is_rotation, const std::string& where) {
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) return {};
  const bool is_short = accessor.componentType == TINYGLTF_COMPONENT_TYPE_BYTE ||
                        accessor.componentType == TINYGLTF_COMPONENT_TYPE_SHORT;
  if (is_rotation && is_short && accessor.normalized) return {};
  return Error{where + " has the componentType " + std::to_string(accessor.componentType) +
               (accessor.normalized ? ", normalized" : ", not normalized") +
               ", which EXT_mesh_gpu_instancing does not allow"};
}

glm::mat4 matrix_of(const Parts& parts) {
  const glm::mat4 turned =
      glm::translate(glm::mat4(1), parts.translation) *
      glm::mat4_cast(glm::quat(parts.rotation.w, parts.rotation.x, parts.rotation.y, parts.rotation.z));
  return glm::scale(turned, parts.scale);
}

Result<std::optional<std::vector<glm::mat4>>> Instancing::node_from_instances(const tinygltf::Node& source,
                                                                              const std::string& where) {
  const auto extension = source.extensions.find("EXT_mesh_gpu_instancing");
  if (extension == source.extensions.end()) return std::optional<std::vector<glm::mat4>>();
  const std::string name = where + ".extensions.EXT_mesh_gpu_instancing";
  if (!extension->second.Has("attributes")) return Error{name + ": attributes is missing"};
  const tinygltf::Value& attributes = extension->second.Get("attributes");

  std::vector<Parts> parts;
  const AccessorReader reader(document_, limits_);
  struct Attribute {
    const char* name;
    size_t first_float;
    int components;
  };
  for (const Attribute& attribute :
       {Attribute{"TRANSLATION", 0, 3}, Attribute{"ROTATION", 3, 4}, Attribute{"SCALE", 7, 3}}) {
    const int accessor = index_or(attributes, attribute.name, -1);
    if (accessor < 0) continue;
    const std::string at = name + ".attributes." + attribute.name;
    auto count = reader.count(accessor, at);
    if (!count) return count.error();
    const bool is_rotation = attribute.components == 4;
    if (auto ok = check_type(document_.model.accessors[static_cast<size_t>(accessor)], is_rotation, at); !ok)
      return ok.error();
    if (parts.empty()) {
      if (*count > kMaxInstances - instances_)
        return Error{at + ": the file holds more than " + std::to_string(kMaxInstances) +
                     " instances; split it"};
      if (*count > limits_.max_nodes)
        return Error{at + ": the file has more than " + std::to_string(limits_.max_nodes) + " nodes"};
      instances_ += *count;
      parts.resize(*count);
    } else if (*count != parts.size()) {
      return Error{at + " has " + std::to_string(*count) + " elements, but another attribute has " +
                   std::to_string(parts.size())};
    }
    auto done = reader.read_floats(accessor, at, &parts[0].translation.x + attribute.first_float, kPartFloats,
                                   attribute.components, attribute.components);
    if (!done) return done.error();
  }
  if (parts.empty())
    return Error{name +
                 " has neither TRANSLATION nor ROTATION nor SCALE: the number of instances is unknown"};

  std::vector<glm::mat4> node_from_instance;
  node_from_instance.reserve(parts.size());
  for (Parts& part : parts) {
    const float length = glm::length(part.rotation);
    if (!(length > 1e-6f) || !std::isfinite(length)) {
      return Error{name + ".attributes.ROTATION holds, at " + std::to_string(node_from_instance.size()) +
                   ", no rotation: its length is not 1"};
    }
    part.rotation /= length;
    node_from_instance.push_back(matrix_of(part));
  }
  return std::optional(std::move(node_from_instance));
}

// Parent of each node in file order. Fails on invalid child indices and on nodes with several parents.
Result<std::vector<uint32_t>> parents_of(const std::vector<tinygltf::Node>& nodes) {
  std::vector<uint32_t> parents(nodes.size(), kNone);
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (const int child : nodes[i].children) {
      if (!in_range(child, nodes.size()))
        return out_of_range(element("nodes", i) + ".children", "nodes", child, nodes.size());
      uint32_t& parent = parents[static_cast<size_t>(child)];
      if (parent != kNone) {
        return Error{element("nodes", static_cast<size_t>(child)) + " is a child of " +
                     element("nodes", parent) + " and of " + element("nodes", i)};
      }
      parent = static_cast<uint32_t>(i);
    }
  }
  return parents;
}

// Finds cycles by walking to the root; each node is visited once.
Result<void> refuse_cycles(const std::vector<uint32_t>& parents) {
  std::vector<uint32_t> walk_of(parents.size(), kNone);
  for (uint32_t start = 0; start < parents.size(); ++start) {
    uint32_t node = start;
    while (node != kNone && walk_of[node] == kNone) {
      walk_of[node] = start;
      node = parents[node];
    }
    if (node != kNone && walk_of[node] == start)
      return Error{element("nodes", node) + " is its own ancestor"};
  }
  return {};
}

// True if a root of the scene is an ancestor of the node. Results are cached, since deep files would
// otherwise take quadratic time.
class BelowRoot {
 public:
  BelowRoot(const std::vector<uint32_t>& parents, const std::vector<bool>& is_root)
      : parents_(parents), is_root_(is_root), known_(parents.size()) {}

  bool operator()(uint32_t node) {
    walked_.clear();
    uint32_t above = parents_[node];
    while (above != kNone && !is_root_[above] && !known_[above]) {
      walked_.push_back(above);
      above = parents_[above];
    }
    const bool below = above != kNone && (is_root_[above] || *known_[above]);
    for (const uint32_t walked : walked_) known_[walked] = below;
    return below;
  }

 private:
  const std::vector<uint32_t>& parents_;
  const std::vector<bool>& is_root_;
  std::vector<std::optional<bool>> known_;
  std::vector<uint32_t> walked_;
};

// Root nodes of the default scene.
Result<std::vector<uint32_t>> roots_of(const GltfDocument& document, const std::vector<uint32_t>& parents,
                                       std::vector<std::string>& warnings) {
  const tinygltf::Model& model = document.model;
  std::vector<uint32_t> roots;
  if (model.scenes.empty()) {
    for (uint32_t i = 0; i < parents.size(); ++i) {
      if (parents[i] == kNone) roots.push_back(i);
    }
    return roots;
  }
  const int shown = model.defaultScene < 0 ? 0 : model.defaultScene;
  if (!in_range(shown, model.scenes.size()))
    return out_of_range("scene", "scenes", shown, model.scenes.size());
  const std::string where = element("scenes", static_cast<size_t>(shown));
  std::vector<bool> is_root(parents.size(), false);
  for (const int node : model.scenes[static_cast<size_t>(shown)].nodes) {
    if (!in_range(node, parents.size())) return out_of_range(where, "nodes", node, parents.size());
    if (is_root[static_cast<size_t>(node)]) {
      warnings.push_back(where + " names " + element("nodes", static_cast<size_t>(node)) + " twice");
      continue;
    }
    is_root[static_cast<size_t>(node)] = true;
    roots.push_back(static_cast<uint32_t>(node));
  }
  // Some exporters also list descendants of roots, which are reached anyway.
  BelowRoot below_root(parents, is_root);
  std::erase_if(roots, [&](uint32_t node) {
    if (parents[node] == kNone) return false;
    const bool reached = below_root(node);
    warnings.push_back(where + " names " + element("nodes", node) + ", which is not a root" +
                       (reached ? "; it is shown below its parent" : "; it is shown without its parent"));
    return reached;
  });
  return roots;
}

Result<void> check_length(const std::vector<double>& numbers, size_t length, const std::string& where,
                          const char* member) {
  if (numbers.empty() || numbers.size() == length) return {};
  return Error{where + "." + member + " holds " + std::to_string(numbers.size()) + " numbers, not " +
               std::to_string(length)};
}

Result<void> set_transform(const tinygltf::Node& source, const std::string& where, Node& node) {
  if (auto ok = check_length(source.matrix, 16, where, "matrix"); !ok) return ok;
  if (auto ok = check_length(source.translation, 3, where, "translation"); !ok) return ok;
  if (auto ok = check_length(source.rotation, 4, where, "rotation"); !ok) return ok;
  if (auto ok = check_length(source.scale, 3, where, "scale"); !ok) return ok;
  if (!source.matrix.empty()) {
    glm::mat4 matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = to_float(source.matrix[static_cast<size_t>(i)]);
    if (matrix[0][3] != 0 || matrix[1][3] != 0 || matrix[2][3] != 0 || matrix[3][3] != 1) {
      return Error{where + ".matrix is not affine: its last row is not 0 0 0 1"};
    }
    node.parent_from_node = matrix;
    node.given_by_matrix = true;
    return {};
  }
  const auto vec3_or = [](const std::vector<double>& numbers, glm::vec3 otherwise) {
    return numbers.empty() ? otherwise
                           : glm::vec3(to_float(numbers[0]), to_float(numbers[1]), to_float(numbers[2]));
  };
  if (!source.rotation.empty()) {
    const glm::dquat given(source.rotation[3], source.rotation[0], source.rotation[1], source.rotation[2]);
    const double length = glm::length(given);
    if (!(length > 1e-6) || !std::isfinite(length))
      return Error{where + ".rotation is no rotation: its length is not 1"};
    node.rotation = glm::quat(given / length);
  }
  node.translation = vec3_or(source.translation, glm::vec3(0));
  node.scale = vec3_or(source.scale, glm::vec3(1));
  node.parent_from_node = parent_from_parts(node.translation, node.rotation, node.scale);
  return {};
}

// Checks an optional reference; kNone if it is missing.
Result<uint32_t> reference(int index, size_t size, const std::string& where, const char* array) {
  if (index < 0) return kNone;
  if (!in_range(index, size)) return out_of_range(where, array, index, size);
  return static_cast<uint32_t>(index);
}

int light_index(const tinygltf::Node& source) {
  const auto extension = source.extensions.find("KHR_lights_punctual");
  if (extension == source.extensions.end() || !extension->second.Has("light")) return -1;
  return extension->second.Get("light").GetNumberAsInt();
}

// Semantic class from the node's extras ("semantic", an integer); glTF has no such member. Descendants
// inherit it.
uint32_t semantic_of(const tinygltf::Node& source, uint32_t inherited, const std::string& where,
                     std::vector<std::string>& warnings) {
  if (!source.extras.Has("semantic")) return inherited;
  const double number = number_or(source.extras, "semantic", -1);
  if (number >= 0 && number <= UINT32_MAX && number == std::floor(number))
    return static_cast<uint32_t>(number);
  warnings.push_back(where + ".extras.semantic is not a whole number from 0 to 4294967295, and is left out");
  return inherited;
}

// KHR_node_visibility, of the node alone.
bool is_visible(const tinygltf::Node& source) {
  const auto extension = source.extensions.find("KHR_node_visibility");
  if (extension == source.extensions.end() || !extension->second.Has("visible")) return true;
  const tinygltf::Value& visible = extension->second.Get("visible");
  return !visible.IsBool() || visible.Get<bool>();
}

// hidden: by itself or by an ancestor. The node keeps its place, name and camera.
Result<Node> node_of(const tinygltf::Node& source, uint32_t parent, bool hidden, const std::string& where,
                     Scene& scene) {
  Node node;
  node.name = source.name;
  node.parent = parent;
  if (auto done = set_transform(source, where, node); !done) return done.error();
  node.world_from_node = node.parent_from_node;
  if (parent != kNone) node.world_from_node = scene.nodes[parent].world_from_node * node.parent_from_node;
  node.path = path_part(source.name);
  if (parent != kNone) node.path = scene.nodes[parent].path + "/" + node.path;

  auto mesh = reference(source.mesh, scene.meshes.size(), where, "meshes");
  if (!mesh) return mesh.error();
  auto camera = reference(source.camera, scene.cameras.size(), where, "cameras");
  if (!camera) return camera.error();
  auto light = reference(light_index(source), scene.lights.size(), where, "lights");
  if (!light) return light.error();
  node.semantic =
      semantic_of(source, parent == kNone ? 0 : scene.nodes[parent].semantic, where, scene.warnings);
  node.mesh = hidden ? kNone : *mesh;
  node.camera = *camera;
  node.light = hidden ? kNone : *light;
  return node;
}

// Moves the node's mesh to its instances. Instances have neither name nor path, so that they cannot hide file
// nodes; a stream drives the node together with its instances.
void add_instances(const std::vector<glm::mat4>& node_from_instances, uint32_t node, Scene& scene) {
  const uint32_t mesh = scene.nodes[node].mesh;
  scene.nodes[node].mesh = kNone;
  if (mesh == kNone) return;
  for (const glm::mat4& node_from_instance : node_from_instances) {
    Node instance;
    instance.parent = node;
    instance.parent_from_node = node_from_instance;
    instance.world_from_node = scene.nodes[node].world_from_node * node_from_instance;
    instance.mesh = mesh;
    instance.semantic = scene.nodes[node].semantic;
    instance.first_morph_weight = scene.nodes[node].first_morph_weight;
    instance.morph_weight_count = scene.nodes[node].morph_weight_count;
    scene.nodes.push_back(std::move(instance));
  }
}

}  // namespace

Result<std::vector<uint32_t>> add_nodes(const GltfDocument& document, const LoadLimits& limits,
                                        Scene& scene) {
  const std::vector<tinygltf::Node>& nodes = document.model.nodes;
  auto parents = parents_of(nodes);
  if (!parents) return parents.error();
  if (auto done = refuse_cycles(*parents); !done) return done.error();
  auto roots = roots_of(document, *parents, scene.warnings);
  if (!roots) return roots.error();

  struct Pending {
    uint32_t source, parent;
    bool hidden;
  };
  std::vector<Pending> pending;
  for (auto root = roots->rbegin(); root != roots->rend(); ++root) pending.push_back({*root, kNone, false});
  Instancing instancing(document, limits);
  std::vector<uint32_t> node_of_source(nodes.size(), kNone);
  uint64_t path_bytes = 0;
  while (!pending.empty()) {
    const Pending next = pending.back();
    pending.pop_back();
    const std::string where = element("nodes", next.source);
    const bool hidden = next.hidden || !is_visible(nodes[next.source]);
    auto node = node_of(nodes[next.source], next.parent, hidden, where, scene);
    if (!node) return node.error();
    path_bytes += node->path.size();
    if (path_bytes > limits.max_path_bytes)
      return Error{where + " lies so deep that the paths of the nodes exceed " +
                   std::to_string(limits.max_path_bytes >> 20) + " MiB"};
    auto weights = add_morph_weights(document, nodes[next.source], where, *node, scene);
    if (!weights) return weights.error();
    const auto index = static_cast<uint32_t>(scene.nodes.size());
    node_of_source[next.source] = index;
    scene.nodes.push_back(std::move(*node));
    auto instances = instancing.node_from_instances(nodes[next.source], where);
    if (!instances) return instances.error();
    if (scene.nodes.size() + (*instances ? (*instances)->size() : 0) > limits.max_nodes)
      return Error{where + ": the file has more than " + std::to_string(limits.max_nodes) + " nodes"};
    if (*instances) add_instances(**instances, index, scene);
    const auto& children = nodes[next.source].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      pending.push_back({static_cast<uint32_t>(*child), index, hidden});
    }
  }
  return node_of_source;
}

}  // namespace fire3dv::scene
