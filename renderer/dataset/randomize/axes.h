// Rotation and scale of transforms.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace fire3dv::dataset {

// Of an affine matrix without shear. A mirror is a negative scale in x.
struct Axes {
  glm::dquat rotation;
  glm::dvec3 scale;
};
Axes axes_of(const glm::dmat4& matrix);

}  // namespace fire3dv::dataset
