// Surfaces of descriptions: primitive shapes (Z up, centred, watertight where the shape is closed),
// transforms, merging, and repair of surfaces from files.
#pragma once

#include <glm/glm.hpp>
#include <string>

#include "convert/model.h"

namespace fire3dv::convert {

Surface box(const glm::dvec3& half_extents);
Surface ellipsoid(const glm::dvec3& radii);
Surface cylinder(double radius, double half_length);                            // along Z
Surface cone(double radius, double half_length);                                // along Z, tip up
Surface capsule(double radius, double half_length);                             // along Z; half length
                                                                                // without caps
Surface rectangle(double half_x, double half_y, const glm::dvec2& uv_repeats);  // in XY, facing +Z
// Rectangle in XY, facing +Z, that reaches the horizon along the axes whose half side is 0. extent: of the
// scene. uv_repeats: of the texture, for each unit of length.
Surface horizon_plane(const glm::dvec2& half, double extent, const glm::dvec2& uv_repeats);

// Appends a surface, transformed to the mesh's frame. Surfaces of equal material are merged. Mirroring
// reverses the winding.
void add_surface(Mesh& mesh, const Surface& surface, const glm::dmat4& mesh_from_surface, size_t material);

glm::dmat4 matrix_of(const glm::dvec3& translation, const glm::dquat& rotation);

// Repairs a surface from a file to satisfy glTF. Removes triangles with missing or non-finite vertices, and
// replaces invalid normals by those of adjacent triangles. Returns a description of the repairs, or "".
std::string repair(Surface& surface);

// Describes nodes with colours of opacity 0, which are not drawn; "" if there are none.
std::string describe_invisible(const Model& model);

}  // namespace fire3dv::convert
