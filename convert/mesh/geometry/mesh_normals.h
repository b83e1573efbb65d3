// Vertex normals of triangle meshes without any, smooth over edges below an angle.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace fire3dv::convert {

// Cosine of the angle between faces up to which their common edge is smooth: 37 degrees, MuJoCo's limit.
constexpr double kSmoothCosine = 0.8;
constexpr double kAllSmooth = -2;  // smooth over all edges

// Weights of the faces at a vertex. area: MuJoCo's. area_and_angle: also the angle at the vertex, so that the
// triangulation of a facet does not matter.
enum class NormalWeights : uint8_t { area, area_and_angle };

// One normal per corner of each face: the weighted mean of the faces at its vertex whose angle to this face
// has at least this cosine. Unit length.
std::vector<glm::vec3> corner_normals(const std::vector<glm::dvec3>& vertices,
                                      const std::vector<std::array<uint32_t, 3>>& faces, double least_cosine,
                                      NormalWeights weights);

}  // namespace fire3dv::convert
