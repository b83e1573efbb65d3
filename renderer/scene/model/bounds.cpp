#include "renderer/scene/model/bounds.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "renderer/scene/clusters/clusters.h"

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
    world.add(bounds_in_world(scene, node, world_from_node));
  if (world.empty()) return;
  scene.bounds_min = world.low;
  scene.bounds_max = world.high;
}

namespace {

// A value with its position, in double, since sums of valid coordinates overflow float.
template <typename T>
struct Placed {
  glm::dvec3 place;
  // Tie-breaker of equal positions, so that the order does not depend on the standard library.
  uint32_t number;
  T value;
};

template <typename T>
int longest_axis(std::span<const Placed<T>> some) {
  glm::dvec3 low = some[0].place, high = low;
  for (const Placed<T>& one : some) {
    low = glm::min(low, one.place);
    high = glm::max(high, one.place);
  }
  const glm::dvec3 size = high - low;
  int axis = size.y > size.x ? 1 : 0;
  if (size.z > size[axis]) axis = 2;
  return axis;
}

// Recursive median split along the longest axis. Ranges of `least` stay unsorted; the first half has a
// multiple of it.
template <typename T>
void sort_into_halves(std::span<Placed<T>> some, size_t least) {
  if (some.size() <= least) return;
  const int axis = longest_axis<T>(some);
  const size_t pieces = (some.size() + least - 1) / least, half = (pieces + 1) / 2 * least;
  std::nth_element(some.begin(), some.begin() + static_cast<ptrdiff_t>(half), some.end(),
                   [axis](const Placed<T>& a, const Placed<T>& b) {
                     return a.place[axis] != b.place[axis] ? a.place[axis] < b.place[axis]
                                                           : a.number < b.number;
                   });
  sort_into_halves(some.first(half), least);
  sort_into_halves(some.subspan(half), least);
}

template <typename T>
void write_back(std::span<const Placed<T>> sorted, std::span<T> values) {
  for (size_t i = 0; i < values.size(); ++i) values[i] = sorted[i].value;
}

}  // namespace

void order_for_ray_boxes(std::span<Corners> triangles, std::span<const glm::vec3> vertices) {
  std::vector<Placed<Corners>> boxes_by_center;
  boxes_by_center.reserve(triangles.size());
  for (const Corners& t : triangles) {
    const glm::dvec3 sum =
        glm::dvec3(vertices[t[0]]) + glm::dvec3(vertices[t[1]]) + glm::dvec3(vertices[t[2]]);
    boxes_by_center.push_back({sum, static_cast<uint32_t>(boxes_by_center.size()), t});
  }
  sort_into_halves<Corners>(boxes_by_center, kRayBoxTriangles);
  write_back<Corners>(boxes_by_center, triangles);
}

std::vector<RayAabb> ray_boxes_of(std::span<const Cluster> clusters, std::span<const uint32_t> triangles,
                                  std::span<const uint32_t> source_vertices,
                                  std::span<const glm::vec3> positions) {
  std::vector<Placed<RayAabb>> boxes_by_center;
  for (const Cluster& cluster : clusters) {
    const auto position = [&](uint32_t vertex) {
      return positions[source_vertices[cluster.first_vertex + vertex]];
    };
    for (uint32_t first = 0; first < cluster.triangle_count; first += kRayBoxTriangles) {
      const uint32_t count = std::min(kRayBoxTriangles, cluster.triangle_count - first);
      RayAabb box;
      box.first_vertex = cluster.first_vertex;
      box.triangles = (cluster.first_triangle + first) | (count - 1) << kRayBoxCountShift;
      box.low = box.high = position(triangles[cluster.first_triangle + first] & 0xff);
      for (uint32_t t = 0; t < count; ++t) {
        const uint32_t packed = triangles[cluster.first_triangle + first + t];
        for (const uint32_t vertex : {packed & 0xff, packed >> 8 & 0xff, packed >> 16}) {
          box.low = glm::min(box.low, position(vertex));
          box.high = glm::max(box.high, position(vertex));
        }
      }
      const glm::dvec3 center = 0.5 * (glm::dvec3(box.low) + glm::dvec3(box.high));
      boxes_by_center.push_back({center, static_cast<uint32_t>(boxes_by_center.size()), box});
    }
  }
  sort_into_halves<RayAabb>(boxes_by_center, 1);
  std::vector<RayAabb> boxes(boxes_by_center.size());
  write_back<RayAabb>(boxes_by_center, boxes);
  return boxes;
}

}  // namespace fire3dv::scene
