#include "renderer/scene/model/bounds.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace fire3dv::scene {
namespace {

// Relative margin on the largest term of a sum. It covers float rounding in any order of evaluation, on the
// GPU, too.
constexpr float kRounding = 1.0f / (1 << 18);

struct Interval {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  void add(float value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void add(const Interval& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
};
using Intervals = std::vector<Interval>;  // weight range of each morph target

void merge(Intervals& into, const Intervals& from) {
  into.resize(std::max(into.size(), from.size()));
  for (size_t i = 0; i < from.size(); ++i) into[i].add(from[i]);
}

// Range of weights over a channel. A cubic segment lies in the convex hull of its Bezier control points.
Intervals weights_of_channel(const Scene& scene, const AnimationChannel& channel) {
  const uint32_t width = channel.width;
  const bool spline = channel.interpolation == Interpolation::cubic_spline;
  // part: 0 in-tangent, 1 value, 2 out-tangent.
  const auto value = [&](uint32_t key, uint32_t part, uint32_t target) {
    const size_t element = spline ? size_t{key} * 3 + part : key;
    return scene.key_values[channel.first_value + element * width + target];
  };
  Intervals result(width);
  for (uint32_t key = 0; key < channel.key_count; ++key) {
    for (uint32_t target = 0; target < width; ++target) result[target].add(value(key, 1, target));
    if (!spline || key + 1 == channel.key_count) continue;
    const float* times = &scene.key_times_s[channel.first_time];
    const float third = (times[key + 1] - times[key]) / 3;
    for (uint32_t target = 0; target < width; ++target) {
      result[target].add(value(key, 1, target) + third * value(key, 2, target));
      result[target].add(value(key + 1, 1, target) - third * value(key + 1, 0, target));
    }
  }
  return result;
}

std::vector<Intervals> weights_of_meshes(const Scene& scene) {
  // Cached, since thousands of channels may share keys, and nodes may share weights.
  std::map<std::pair<uint32_t, uint32_t>, Intervals> of_keys;
  std::map<uint32_t, Intervals> of_weights;
  for (const AnimationChannel& channel : scene.channels) {
    if (channel.path != AnimationPath::weights) continue;
    auto [entry, is_new] = of_keys.try_emplace({channel.first_time, channel.first_value});
    if (is_new) entry->second = weights_of_channel(scene, channel);
    merge(of_weights[scene.nodes[channel.node].first_morph_weight], entry->second);
  }
  std::vector<Intervals> of_mesh(scene.meshes.size());
  for (const Node& node : scene.nodes) {
    if (node.mesh == kNone || node.morph_weight_count == 0) continue;
    Intervals weights(node.morph_weight_count);
    for (uint32_t i = 0; i < node.morph_weight_count; ++i)
      weights[i].add(scene.morph_weights[node.first_morph_weight + i]);
    if (const auto animated = of_weights.find(node.first_morph_weight); animated != of_weights.end())
      merge(weights, animated->second);
    merge(of_mesh[node.mesh], weights);
  }
  return of_mesh;
}

// Bounding box of each vertex over the given weight ranges.
std::vector<Box> morphed(const Scene& scene, const Primitive& primitive, const Intervals& weights) {
  std::vector<Box> boxes(primitive.vertex_count);
  for (uint32_t v = 0; v < primitive.vertex_count; ++v)
    boxes[v].add(scene.positions[primitive.first_vertex + v]);
  if (primitive.morph_target_count == 0 || weights.empty()) return boxes;
  std::vector<glm::vec3> largest(primitive.vertex_count);
  for (uint32_t v = 0; v < primitive.vertex_count; ++v) largest[v] = glm::abs(boxes[v].low);
  for (uint32_t t = 0; t < std::min<size_t>(primitive.morph_target_count, weights.size()); ++t) {
    const Interval& weight = weights[t];
    const MorphDelta* deltas =
        &scene.morph_deltas[primitive.first_morph_delta + size_t{t} * primitive.vertex_count];
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      const glm::vec3 a = weight.low * deltas[v].position, b = weight.high * deltas[v].position;
      boxes[v].low += glm::min(a, b);
      boxes[v].high += glm::max(a, b);
      largest[v] += glm::max(glm::abs(a), glm::abs(b));
    }
  }
  for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
    boxes[v].low -= largest[v] * kRounding;
    boxes[v].high += largest[v] * kRounding;
  }
  return boxes;
}

void add_joint_bounds(Scene& scene, Primitive& primitive, const std::vector<Box>& vertices) {
  primitive.first_joint_bounds = static_cast<uint32_t>(scene.joint_bounds.size());
  std::vector<Box> of_joint(primitive.joint_limit);
  for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
    for (uint32_t set = 0; set < primitive.influence_sets; ++set) {
      const Influences& influences =
          scene.influences[primitive.first_influence + size_t{v} * primitive.influence_sets + set];
      for (size_t i = 0; i < 4; ++i) {
        if (influences.weights[i] > 0) of_joint[influences.joints[i]].add(vertices[v]);
      }
    }
  }
  for (uint32_t joint = 0; joint < of_joint.size(); ++joint) {
    if (!of_joint[joint].empty())
      scene.joint_bounds.push_back({joint, of_joint[joint].low, of_joint[joint].high});
  }
  primitive.joint_bounds_count =
      static_cast<uint32_t>(scene.joint_bounds.size()) - primitive.first_joint_bounds;
}

void add_corners(const glm::mat4& world_from_box, const glm::vec3& low, const glm::vec3& high, Box& world) {
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 local((corner & 1) ? high.x : low.x, (corner & 2) ? high.y : low.y,
                          (corner & 4) ? high.z : low.z);
    world.add(glm::vec3(world_from_box * glm::vec4(local, 1)));
  }
}

Box skinned(const Scene& scene, const Skin& skin, const Primitive& primitive,
            std::span<const glm::mat4> world_from_node) {
  Box world;
  for (uint32_t i = 0; i < primitive.joint_bounds_count; ++i) {
    const JointBounds& bounds = scene.joint_bounds[primitive.first_joint_bounds + i];
    const Joint& joint = scene.joints[skin.first_joint + bounds.joint];
    add_corners(world_from_node[joint.node] * joint.joint_from_mesh, bounds.bounds_min, bounds.bounds_max,
                world);
  }
  const glm::vec3 rounding = kRounding * glm::max(glm::abs(world.low), glm::abs(world.high));
  world.low -= rounding;
  world.high += rounding;
  return world;
}

}  // namespace

void bound_deformed_primitives(Scene& scene) {
  const std::vector<Intervals> of_mesh = weights_of_meshes(scene);
  // Primitives share vertices within and across meshes; each vertex range is evaluated once.
  std::map<uint32_t, Intervals> of_vertices;
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const Primitive& primitive = scene.primitives[p];
      if (primitive.morph_target_count == 0 && primitive.first_influence == kNone) continue;
      merge(of_vertices[primitive.first_vertex], of_mesh[m]);
    }
  }
  std::map<uint32_t, Primitive> done;
  for (Primitive& primitive : scene.primitives) {
    const auto weights = of_vertices.find(primitive.first_vertex);
    if (weights == of_vertices.end()) continue;
    const auto [known, is_new] = done.try_emplace(primitive.first_vertex);
    if (is_new) {
      const std::vector<Box> vertices = morphed(scene, primitive, weights->second);
      Box whole;
      for (const Box& vertex : vertices) whole.add(vertex);
      primitive.bounds_min = whole.low;
      primitive.bounds_max = whole.high;
      if (primitive.first_influence != kNone) add_joint_bounds(scene, primitive, vertices);
      known->second = primitive;
      continue;
    }
    primitive.bounds_min = known->second.bounds_min;
    primitive.bounds_max = known->second.bounds_max;
    primitive.first_joint_bounds = known->second.first_joint_bounds;
    primitive.joint_bounds_count = known->second.joint_bounds_count;
  }
}

Box bounds_in_world(const Scene& scene, uint32_t node, std::span<const glm::mat4> world_from_node) {
  Box world;
  const Node& source = scene.nodes[node];
  if (source.mesh == kNone) return world;
  const Mesh& mesh = scene.meshes[source.mesh];
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const Primitive& primitive = scene.primitives[p];
    if (source.skin != kNone && primitive.first_influence != kNone) {
      world.add(skinned(scene, scene.skins[source.skin], primitive, world_from_node));
    } else {
      add_corners(world_from_node[node], primitive.bounds_min, primitive.bounds_max, world);
    }
  }
  return world;
}

void find_world_bounds(Scene& scene) {
  std::vector<glm::mat4> world_from_node;
  for (const Node& node : scene.nodes) world_from_node.push_back(node.world_from_node);
  Box world;
  for (uint32_t node = 0; node < scene.nodes.size(); ++node)
    if (!is_unbounded(scene, node)) world.add(bounds_in_world(scene, node, world_from_node));
  // Of a scene of infinite surfaces, they are all that there is.
  for (uint32_t node = 0; world.empty() && node < scene.nodes.size(); ++node)
    world.add(bounds_in_world(scene, node, world_from_node));
  if (world.empty()) return;
  scene.bounds_min = world.low;
  scene.bounds_max = world.high;
}

}  // namespace fire3dv::scene
