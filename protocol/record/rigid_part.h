// Rigid part (rotation and translation) of an affine transform, for formats without scale.
#pragma once

#include <array>

#include "protocol/wire/affine.h"

namespace fire3dv::record {

struct RigidPart {
  std::array<double, 4> rotation_xyzw{0, 0, 0, 1};  // unit length
  std::array<double, 3> translation{};
};

// Nearest rotation to the 3x3 part (least squares over its elements). For a rotation with uniform scale it is
// that rotation up to rounding. Reflections and singular matrices also have a nearest rotation, which may not
// be unique; the zero matrix yields the identity.
RigidPart rigid_part(const wire::Affine3x4d& map);

wire::Affine3x4d product(const wire::Affine3x4d& a, const wire::Affine3x4& b);

}  // namespace fire3dv::record
