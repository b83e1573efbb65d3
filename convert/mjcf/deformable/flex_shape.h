// Points and elements of MuJoCo's deformable objects (flexes): generated shapes, and the surface that is
// drawn.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "convert/model.h"

namespace fire3dv::convert {

struct FlexShape {
  int dimension = 2;  // of the elements: lines, triangles or tetrahedra
  std::vector<glm::dvec3> points;
  std::vector<uint32_t> elements;     // dimension + 1 points each, in bounds
  std::vector<glm::vec2> uvs;         // v grows downwards in the image
  std::vector<uint32_t> uv_elements;  // into uvs, one per corner of the elements; empty: no uvs
};

// Regular shape around the origin, as the attributes type, count and spacing of flexcomp. At most 250,000
// points. The error is a sentence end about the object.
struct FlexGrid {
  std::string type;
  std::array<int, 3> count{10, 10, 10};
  glm::dvec3 spacing{0.02};
};
Result<FlexShape> flex_grid(const FlexGrid& grid, int dimension);

// Surface of the elements: triangles, the outside of tetrahedra, or a capsule for each line. Normals are left
// to the caller.
struct FlexSurface {
  Surface surface;
  std::vector<uint32_t> points;  // of the shape that a vertex moves with
};
// is_flat: corners of different triangles are different vertices.
FlexSurface flex_surface(const FlexShape& shape, double radius, bool is_flat);

}  // namespace fire3dv::convert
