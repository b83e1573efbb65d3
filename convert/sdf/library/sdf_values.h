// Values of libsdformat as those of glm.
#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <ignition/math/Color.hh>
#include <ignition/math/Pose3.hh>
#include <ignition/math/Vector2.hh>
#include <ignition/math/Vector3.hh>

namespace fire3dv::convert {

inline glm::dvec3 vec3(const ignition::math::Vector3d& v) {
  return {v.X(), v.Y(), v.Z()};
}
inline glm::dvec2 vec2(const ignition::math::Vector2d& v) {
  return {v.X(), v.Y()};
}
inline glm::dquat quat(const ignition::math::Quaterniond& q) {
  return {q.W(), q.X(), q.Y(), q.Z()};
}
inline glm::vec4 vec4(const ignition::math::Color& c) {
  return {c.R(), c.G(), c.B(), c.A()};
}

// Finite and within 1e9 metres, so that numbers of 32 bits and their squares are finite, too.
inline bool is_sound(const ignition::math::Pose3d& pose) {
  constexpr double kFarthest = 1e9;
  const glm::dvec3 p = vec3(pose.Pos());
  const glm::dquat q = quat(pose.Rot());
  const double length = glm::length(q);
  return std::isfinite(length) && length > 1e-6 && std::abs(p.x) <= kFarthest && std::abs(p.y) <= kFarthest &&
         std::abs(p.z) <= kFarthest;
}

}  // namespace fire3dv::convert
