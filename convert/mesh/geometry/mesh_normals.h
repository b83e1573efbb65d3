// Vertex normals of triangle meshes without any.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace fire3dv::convert {

// One normal per corner of each face: the mean, weighted by area, of the faces at its vertex that are within
// 37 degrees of this face (MuJoCo's limit), or of all of them if `smooth`. Unit length.
std::vector<glm::vec3> corner_normals(const std::vector<glm::dvec3>& vertices,
                                      const std::vector<std::array<uint32_t, 3>>& faces, bool smooth);

}  // namespace fire3dv::convert
