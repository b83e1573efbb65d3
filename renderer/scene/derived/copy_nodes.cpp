#include "renderer/scene/derived/copy_nodes.h"

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::scene {
namespace {

class Copier {
 public:
  Copier(Scene& scene, const CopyPlan& plan, uint32_t copy) : scene_(scene), plan_(plan) {
    for (const uint32_t source : plan.sources) copies_.emplace_hint(copies_.end(), source, copy++);
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
    if (!std::ranges::binary_search(plan_.own_skins, number)) return number;
    const auto [own, is_new] = skins_.try_emplace(number, static_cast<uint32_t>(scene_.skins.size()));
    if (!is_new) return own->second;
    Skin skin = scene_.skins[number];
    const uint32_t first_joint = std::exchange(skin.first_joint, static_cast<uint32_t>(scene_.joints.size()));
    for (uint32_t i = 0; i < skin.joint_count; ++i) {
      Joint joint = scene_.joints[first_joint + i];
      joint.node = copies_.at(joint.node);
      scene_.joints.push_back(joint);
    }
    scene_.skins.push_back(std::move(skin));
    return own->second;
  }

  Scene& scene_;
  const CopyPlan& plan_;
  std::map<uint32_t, uint32_t> copies_, skins_;
};

Result<void> check_room(const Scene& scene, const CopyPlan& plan, uint64_t deformed_corners) {
  const bool has_room =
      plan.joints + scene.joints.size() < kNone && plan.morph_weights + scene.morph_weights.size() < kNone &&
      (plan.deformed_corners == 0 || plan.deformed_corners + deformed_corners <= kMaxDeformedCorners);
  if (!has_room) return Error{"the scene would have more deformed vertices than there is room for"};
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

CopyPlan plan_copy(const Scene& scene, std::vector<uint32_t> sources) {
  CopyPlan plan;
  plan.host_bytes = sources.size() * sizeof(Node);
  std::set<uint32_t> skins;
  for (const uint32_t source : sources) {
    const Node& node = scene.nodes[source];
    plan.morph_weights += node.morph_weight_count;
    if (node.mesh != kNone && (node.skin != kNone || node.morph_weight_count != 0))
      plan.deformed_corners += corners_of_mesh(scene, scene.meshes[node.mesh]);
    if (node.skin != kNone) skins.insert(node.skin);
  }
  for (const uint32_t number : skins) {
    const Skin& skin = scene.skins[number];
    const auto joints = std::span(scene.joints).subspan(skin.first_joint, skin.joint_count);
    const auto is_copied = [&](const Joint& joint) {
      return std::ranges::binary_search(sources, joint.node);
    };
    if (joints.empty() || !std::ranges::all_of(joints, is_copied)) continue;
    plan.own_skins.push_back(number);
    plan.joints += joints.size();
    plan.host_bytes += sizeof(Skin) + skin.name.size() + joints.size_bytes();
  }
  plan.host_bytes += plan.morph_weights * sizeof(float);
  plan.sources = std::move(sources);
  return plan;
}

uint64_t path_bytes_of_copy(const Scene& scene, const std::vector<uint32_t>& sources,
                            const std::string& path) {
  uint64_t bytes = path.size();
  const size_t prefix = scene.nodes[sources.front()].path.size();
  for (size_t i = 1; i < sources.size(); ++i) {
    const std::string& of_source = scene.nodes[sources[i]].path;
    if (!of_source.empty()) bytes += path.size() + of_source.size() - prefix;
  }
  return bytes;
}

Result<void> copy_below(Scene& scene, const CopyPlan& plan, uint32_t copy, uint64_t& deformed_corners) {
  const std::vector<uint32_t>& sources = plan.sources;
  FIRE3DV_ASSERT(!sources.empty() && copy + 1 == scene.nodes.size());
  if (Result<void> room = check_room(scene, plan, deformed_corners); !room) return room;
  deformed_corners += plan.deformed_corners;
  Copier copier(scene, plan, copy);
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
