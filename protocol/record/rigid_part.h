// What of an affine map is a rotation and a shift: the part that formats without scale can hold.
#pragma once

#include <array>

#include "protocol/wire/affine.h"

namespace fire3dv::record {

struct RigidPart {
  std::array<double, 4> rotation_xyzw{0, 0, 0, 1};  // of length 1
  std::array<double, 3> translation{};
};

// The rotation is the one nearest to the map's 3x3 part (least squares over its elements), so for a rotation
// with a uniform scale it is that rotation, exactly but for rounding. Reflections and maps that flatten
// everything have a nearest rotation, too, if not only one; that of the zero matrix is none at all.
RigidPart rigid_part(const wire::Affine3x4d& map);

wire::Affine3x4d product(const wire::Affine3x4d& a, const wire::Affine3x4& b);

}  // namespace fire3dv::record
