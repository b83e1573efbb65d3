// Transform of a node relative to its parent, as the user edits it: translation, rotation and scale where
// these describe it, else an affine matrix (shear). The parts are what files store and panels show; both
// forms are exact, so that a stored transform reproduces its image.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>

#include "renderer/scene/model/scene.h"
#include "renderer/state/motion/animation.h"

namespace fire3dv::state {

struct NodeTransform {
  glm::vec3 translation{0};  // metres, in the parent's frame
  glm::quat rotation{1, 0, 0, 0};
  glm::vec3 scale{1};
  bool has_shear = false;
  glm::mat4 matrix{1};  // with has_shear, in place of the parts

  bool operator==(const NodeTransform&) const = default;
};
using NodeTransforms = std::map<uint32_t, NodeTransform>;  // by node

glm::mat4 parent_from_node(const NodeTransform& transform);

// Splits an affine matrix into parts. A matrix that they do not describe within rounding keeps its shear.
NodeTransform to_transform(const glm::mat4& parent_from_node);

// True for finite numbers of at most 1e12 in magnitude, a rotation of unit length, and an invertible matrix.
bool is_valid(const NodeTransform& transform);

// Replaces the transforms of these nodes in a rest pose of the scene, and moves the nodes below them.
void apply_transforms(const NodeTransforms& transforms, const scene::Scene& scene, RestPose& pose);

}  // namespace fire3dv::state
