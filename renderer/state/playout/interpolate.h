// Interpolation of two poses: slerp for the rotation, linear for translation and scale. Matrices with shear,
// singular matrices, and pairs of which one is mirrored are interpolated element by element.
#pragma once

#include "protocol/wire/messages.h"

namespace fire3dv::state {

// Returns exactly `a` at t 0 and `b` at t 1; t above 1 extrapolates.
wire::Affine3x4 interpolate(const wire::Affine3x4& a, const wire::Affine3x4& b, double t);

}  // namespace fire3dv::state
