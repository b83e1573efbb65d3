#include "renderer/dataset/randomize/axes.h"

#include <algorithm>

namespace fire3dv::dataset {

Axes axes_of(const glm::dmat4& matrix) {
  glm::dmat3 axes(matrix);
  Axes result{};
  for (int i = 0; i < 3; ++i) {
    result.scale[i] = glm::length(axes[i]);
    axes[i] /= std::max(result.scale[i], 1e-300);
  }
  if (glm::determinant(axes) < 0) {
    axes[0] = -axes[0];
    result.scale.x = -result.scale.x;
  }
  result.rotation = glm::normalize(glm::quat_cast(axes));
  return result;
}

}  // namespace fire3dv::dataset
