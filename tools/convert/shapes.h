// The shapes that robots are described with, as triangles: Z up, centred, closed where the shape is. And how
// surfaces are put together.
#pragma once

#include <glm/glm.hpp>

#include "tools/convert/model.h"

namespace fire3dv::convert {

Surface box(const glm::dvec3& half_extents);
Surface ellipsoid(const glm::dvec3& radii);
Surface cylinder(double radius, double half_length);                            // along Z
Surface capsule(double radius, double half_length);                             // along Z; half without caps
Surface rectangle(double half_x, double half_y, const glm::dvec2& uv_repeats);  // in XY, seen from above

// Adds a surface to a mesh, moved into the mesh's frame. Surfaces of one material become one. Mirroring keeps
// the outside outside.
void add_surface(Mesh& mesh, const Surface& surface, const glm::dmat4& mesh_from_surface, size_t material);

glm::dmat4 matrix_of(const glm::dvec3& translation, const glm::dquat& rotation);

}  // namespace fire3dv::convert
