#include "renderer/scene/model/copy_nodes.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::scene {
namespace {

class Copier {
 public:
  Copier(Scene& scene, const std::vector<uint32_t>& sources, uint32_t copy) : scene_(scene) {
    for (size_t i = 0; i < sources.size(); ++i) copies_[sources[i]] = copy + static_cast<uint32_t>(i);
  }

  uint32_t copy_of(uint32_t source) const { return copies_.at(source); }

  void copy_content(const Node& source, Node& copy) {
    copy.mesh = source.mesh;
    copy.camera = source.camera;
    copy.light = own_light(source.light);
    copy.semantic = source.semantic;
    copy.skin = source.skin == kNone ? kNone : skin_of_copy(source.skin);
    copy.morph_weight_count = source.morph_weight_count;
    copy.first_morph_weight = static_cast<uint32_t>(scene_.morph_weights.size());
    for (uint32_t i = 0; i < source.morph_weight_count; ++i) {
      const float weight = scene_.morph_weights[source.first_morph_weight + i];
      scene_.morph_weights.push_back(weight);
    }
  }

 private:
  // The default light of a scene without lights is replaced by others, its copy is the user's.
  uint32_t own_light(uint32_t light) {
    if (light == kNone || !scene_.lights[light].is_default) return light;
    Light own = scene_.lights[light];
    own.is_default = false;
    scene_.lights.push_back(std::move(own));
    return static_cast<uint32_t>(scene_.lights.size() - 1);
  }

  uint32_t skin_of_copy(uint32_t number) {
    const auto known = skins_.find(number);
    if (known != skins_.end()) return known->second;
    Skin skin = scene_.skins[number];
    std::vector<Joint> joints(scene_.joints.begin() + skin.first_joint,
                              scene_.joints.begin() + skin.first_joint + skin.joint_count);
    const bool is_whole =
        std::ranges::all_of(joints, [&](const Joint& joint) { return copies_.contains(joint.node); });
    uint32_t own = number;
    if (is_whole && !joints.empty()) {
      skin.first_joint = static_cast<uint32_t>(scene_.joints.size());
      for (Joint& joint : joints) joint.node = copies_.at(joint.node);
      scene_.joints.insert(scene_.joints.end(), joints.begin(), joints.end());
      own = static_cast<uint32_t>(scene_.skins.size());
      scene_.skins.push_back(std::move(skin));
    }
    skins_[number] = own;
    return own;
  }

  Scene& scene_;
  std::map<uint32_t, uint32_t> copies_, skins_;
};

// Of the arrays that grow with skins and deformed meshes.
Result<void> check_deformed(const Scene& scene, const std::vector<uint32_t>& sources) {
  uint64_t joints = 0, weights = 0, corners = 0;
  for (const uint32_t source : sources) {
    const Node& node = scene.nodes[source];
    if (node.skin != kNone) joints += scene.skins[node.skin].joint_count;
    weights += node.morph_weight_count;
    if (node.mesh != kNone && (node.skin != kNone || node.morph_weight_count != 0))
      corners += corners_of_mesh(scene, scene.meshes[node.mesh]);
  }
  if (joints + weights == 0) return {};
  if (joints + scene.joints.size() >= kNone || weights + scene.morph_weights.size() >= kNone ||
      corners + deformed_corners(scene) > kMaxDeformedCorners)
    return Error{"the scene would have more deformed vertices than there is room for"};
  return {};
}

}  // namespace

std::vector<uint32_t> Descendants::of(const Scene& scene, uint32_t top,
                                      const std::function<bool(uint32_t)>& is_left_out) {
  const auto indexed = static_cast<uint32_t>(first_child_.size());
  first_child_.resize(scene.nodes.size(), kNone);
  next_sibling_.resize(scene.nodes.size(), kNone);
  for (uint32_t node = indexed; node < scene.nodes.size(); ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    if (parent != kNone) next_sibling_[node] = std::exchange(first_child_[parent], node);
  }
  std::vector<uint32_t> found, pending{top};
  while (!pending.empty()) {
    const uint32_t node = pending.back();
    pending.pop_back();
    found.push_back(node);
    for (uint32_t child = first_child_[node]; child != kNone; child = next_sibling_[child]) {
      if (!is_left_out(child)) pending.push_back(child);
    }
  }
  std::ranges::sort(found);
  return found;
}

Result<void> copy_below(Scene& scene, const std::vector<uint32_t>& sources, uint32_t copy) {
  FIRE3DV_ASSERT(!sources.empty() && copy + 1 == scene.nodes.size());
  if (Result<void> room = check_deformed(scene, sources); !room) return room;
  Copier copier(scene, sources, copy);
  copier.copy_content(scene.nodes[sources.front()], scene.nodes[copy]);
  const size_t prefix = scene.nodes[sources.front()].path.size();
  scene.nodes.reserve(scene.nodes.size() + sources.size() - 1);
  for (size_t i = 1; i < sources.size(); ++i) {
    const Node& source = scene.nodes[sources[i]];
    Node node = source;
    node.name.clear();
    if (!node.path.empty()) node.path = scene.nodes[copy].path + source.path.substr(prefix);
    node.parent = copier.copy_of(source.parent);
    node.world_from_node = scene.nodes[node.parent].world_from_node * node.parent_from_node;
    node.has_instance_vertices = false;
    copier.copy_content(source, node);
    scene.nodes.push_back(std::move(node));
  }
  return {};
}

}  // namespace fire3dv::scene
