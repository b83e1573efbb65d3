// Convex hull of points, for meshes without faces.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "base/error.h"
#include "convert/mjcf/assets/mesh_data.h"

namespace fire3dv::convert {

// Triangles, counter-clockwise seen from outside. At most 5000 points. Fails where all points lie in a plane.
Result<std::vector<MeshData::Triangle>> convex_hull(const std::vector<glm::vec3>& points);

}  // namespace fire3dv::convert
