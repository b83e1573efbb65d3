// Between two poses. Rotation turns at even speed about one axis, places and scales move evenly. A matrix
// that is no rotation with scales along its axes (shear, a flat body), or a pair of which one mirrors and the
// other does not, has no such parts: its elements move evenly.
#pragma once

#include "protocol/wire/messages.h"

namespace fire3dv::state {

// t 0 gives a, 1 gives b, exactly; beyond 1 the motion goes on.
wire::Affine3x4 interpolate(const wire::Affine3x4& a, const wire::Affine3x4& b, double t);

}  // namespace fire3dv::state
