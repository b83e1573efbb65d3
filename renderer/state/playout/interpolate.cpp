#include "renderer/state/playout/interpolate.h"

#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>

namespace fire3dv::state {
namespace {

struct Parts {
  glm::dquat rotation;
  glm::dvec3 scale;  // x is negative for a mirrored matrix
};

// Splits a matrix into rotation and scale. Fails if its columns are not orthogonal within float precision.
std::optional<Parts> split(const wire::Affine3x4& affine) {
  glm::dmat3 matrix;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      matrix[column][row] = static_cast<double>(affine.m[static_cast<size_t>(row * 4 + column)]);
  constexpr double kLeast = 1e-12, kSkew = 1e-4;
  Parts parts;
  for (int column = 0; column < 3; ++column) {
    parts.scale[column] = glm::length(matrix[column]);
    if (!(parts.scale[column] > kLeast)) return {};
    matrix[column] /= parts.scale[column];
  }
  if (std::abs(glm::dot(matrix[0], matrix[1])) > kSkew || std::abs(glm::dot(matrix[1], matrix[2])) > kSkew ||
      std::abs(glm::dot(matrix[2], matrix[0])) > kSkew)
    return {};
  if (glm::determinant(matrix) < 0) {
    matrix[0] = -matrix[0];
    parts.scale.x = -parts.scale.x;
  }
  parts.rotation = glm::normalize(glm::quat_cast(matrix));
  return parts;
}

// Spherical interpolation that also extrapolates (t > 1); glm::slerp does not guarantee that.
glm::dquat turn(const glm::dquat& from, const glm::dquat& to, double t) {
  glm::dquat difference = glm::conjugate(from) * to;
  if (difference.w < 0) difference = -difference;  // the shorter arc
  const glm::dvec3 axis(difference.x, difference.y, difference.z);
  const double sine = glm::length(axis);
  if (sine < 1e-12) return from;
  const double half_angle = std::atan2(sine, difference.w) * t;
  return from * glm::dquat(std::cos(half_angle), axis * (std::sin(half_angle) / sine));
}

float mix(float a, float b, double t) {
  return static_cast<float>(static_cast<double>(a) + (static_cast<double>(b) - static_cast<double>(a)) * t);
}

}  // namespace

wire::Affine3x4 interpolate(const wire::Affine3x4& a, const wire::Affine3x4& b, double t) {
  if (t == 0 || a == b) return a;
  if (t == 1) return b;
  wire::Affine3x4 result;
  for (size_t i = 0; i < 12; ++i) result.m[i] = mix(a.m[i], b.m[i], t);
  const auto first = split(a), second = split(b);
  if (!first || !second || (first->scale.x < 0) != (second->scale.x < 0)) return result;
  const glm::dmat3 rotation = glm::mat3_cast(turn(first->rotation, second->rotation, t));
  const glm::dvec3 scale = first->scale + (second->scale - first->scale) * t;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      result.m[static_cast<size_t>(row * 4 + column)] =
          static_cast<float>(rotation[column][row] * scale[column]);
  return result;
}

}  // namespace fire3dv::state
