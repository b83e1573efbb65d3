// Meshes of AMBF's built-in shapes, centred as in AMBF, along Z. Without material.
#pragma once

#include <glm/glm.hpp>

#include "tools/convert/model.h"

namespace fire3dv::convert {

Surface box_surface(const glm::dvec3& full_extents);
Surface ellipsoid_surface(const glm::dvec3& semi_axes);
// Closed at both ends; a top radius of 0 makes a cone.
Surface cylinder_surface(double height, double bottom_radius, double top_radius);
// Square of 100 x 100 at `offset` along the normal, which need not be normalised.
Surface plane_surface(const glm::dvec3& normal, double offset);

}  // namespace fire3dv::convert
