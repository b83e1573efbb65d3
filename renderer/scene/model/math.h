// Conversions between row-major 3x4 affine matrices of the wire format and column-major GLM matrices.
#pragma once

#include <glm/glm.hpp>

#include "protocol/wire/messages.h"

namespace fire3dv::scene {

inline glm::mat4 to_mat4(const wire::Affine3x4& affine) {
  glm::mat4 matrix(1);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      matrix[column][row] = affine.m[static_cast<size_t>(row * 4 + column)];
  }
  return matrix;
}

inline glm::dmat4 to_dmat4(const wire::Affine3x4d& affine) {
  glm::dmat4 matrix(1);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      matrix[column][row] = affine.m[static_cast<size_t>(row * 4 + column)];
  }
  return matrix;
}

// Assumes the last row (0, 0, 0, 1).
inline wire::Affine3x4 to_affine(const glm::mat4& matrix) {
  wire::Affine3x4 affine;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      affine.m[static_cast<size_t>(row * 4 + column)] = matrix[column][row];
  }
  return affine;
}

inline wire::Affine3x4d to_affine(const glm::dmat4& matrix) {
  wire::Affine3x4d affine;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      affine.m[static_cast<size_t>(row * 4 + column)] = matrix[column][row];
  }
  return affine;
}

}  // namespace fire3dv::scene
