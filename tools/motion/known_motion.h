// A motion of which everybody knows where it is when: a body on a circle of 1 m at 1 m/s, which turns with
// it. A millimetre beside its place is a millisecond beside its time.
#pragma once

#include <cstdint>

#include "protocol/wire/messages.h"

namespace fire3dv::motion {

wire::Affine3x4 known_pose(int64_t sim_time_ns);

double distance_m(const wire::Affine3x4& a, const wire::Affine3x4& b);

}  // namespace fire3dv::motion
