// Shortest path of a tendon around a sphere or an endless cylinder, as MuJoCo computes it.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <utility>

#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

// Points where the path between two points touches the surface and leaves it, in the frame of the points.
// Empty: the straight line is not deflected. pose: of the centre; a cylinder is along its Z axis. side: the
// path passes on the side of this point; a point within the radius makes the path touch the inside of the
// surface.
std::optional<std::pair<glm::dvec3, glm::dvec3>> wrap_tendon(const glm::dvec3& from, const glm::dvec3& to,
                                                             const MjcfPose& pose, double radius,
                                                             bool is_sphere,
                                                             const std::optional<glm::dvec3>& side);

}  // namespace fire3dv::convert
