#include "renderer/state/edits/node_transform.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fire3dv::state {
namespace {

constexpr float kMaxNumber = 1e12f;
constexpr float kLeastVolume = 1e-18f;  // of the transformed unit cube

bool is_number(float value) {
  return std::isfinite(value) && std::abs(value) <= kMaxNumber;
}

bool is_affine_and_invertible(const glm::mat4& matrix) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (!is_number(matrix[column][row])) return false;
    }
    if (matrix[column][3] != (column == 3 ? 1.0f : 0.0f)) return false;
  }
  return std::abs(glm::determinant(glm::mat3(matrix))) >= kLeastVolume;
}

}  // namespace

glm::mat4 parent_from_node(const NodeTransform& transform) {
  if (transform.has_shear) return transform.matrix;
  return scene::parent_from_parts(transform.translation, transform.rotation, transform.scale);
}

NodeTransform to_transform(const glm::mat4& matrix) {
  constexpr float kRounding = 1e-5f;
  NodeTransform parts;
  parts.translation = glm::vec3(matrix[3]);
  glm::mat3 turn(matrix);
  for (int axis = 0; axis < 3; ++axis) parts.scale[axis] = glm::length(turn[axis]);
  const float largest = std::max({parts.scale.x, parts.scale.y, parts.scale.z});
  const bool is_flat = std::min({parts.scale.x, parts.scale.y, parts.scale.z}) <= 0;
  if (!is_flat) {
    if (glm::determinant(turn) < 0) parts.scale.x = -parts.scale.x;  // a mirror image
    for (int axis = 0; axis < 3; ++axis) turn[axis] /= parts.scale[axis];
    parts.rotation = glm::normalize(glm::quat_cast(turn));
    const glm::mat4 again = parent_from_node(parts);
    float error = 0;
    for (int axis = 0; axis < 3; ++axis)
      error = std::max(error, glm::length(glm::vec3(again[axis] - matrix[axis])));
    if (error <= kRounding * largest) return parts;
  }
  NodeTransform sheared;
  sheared.has_shear = true;
  sheared.matrix = matrix;
  return sheared;
}

bool is_valid(const NodeTransform& transform) {
  constexpr float kUnitError = 1e-3f;
  if (!transform.has_shear) {
    const glm::quat& q = transform.rotation;
    for (const float part : {q.x, q.y, q.z, q.w}) {
      if (!is_number(part)) return false;
    }
    if (std::abs(glm::length(q) - 1) > kUnitError) return false;
  }
  return is_affine_and_invertible(parent_from_node(transform));
}

void apply_transforms(const NodeTransforms& transforms, const scene::Scene& scene, RestPose& pose) {
  if (transforms.empty()) return;
  std::vector<bool> is_moved(scene.nodes.size(), false);
  for (const auto& [node, transform] : transforms) {
    if (node >= scene.nodes.size()) continue;
    is_moved[node] = true;
    pose.parent_from_node[node] = parent_from_node(transform);
  }
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {  // parents precede their children
    const uint32_t parent = scene.nodes[node].parent;
    const bool has_parent = parent != scene::kNone;
    if (!is_moved[node] && !(has_parent && is_moved[parent])) continue;
    is_moved[node] = true;
    pose.world_from_node[node] =
        has_parent ? pose.world_from_node[parent] * pose.parent_from_node[node] : pose.parent_from_node[node];
  }
}

}  // namespace fire3dv::state
