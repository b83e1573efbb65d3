// Reference motion, known at any simulated time: a body moves along a circle of 1 m radius at 1 m/s and
// rotates with it. At this speed, 1 mm of position error equals 1 ms of time error.
#pragma once

#include <cstdint>

#include "protocol/wire/messages.h"

namespace fire3dv::motion {

wire::Affine3x4 known_pose(int64_t sim_time_ns);

double distance_m(const wire::Affine3x4& a, const wire::Affine3x4& b);

}  // namespace fire3dv::motion
