// Extruded polygons with holes of SDF's <polyline> elements.
#pragma once

#include <string>
#include <vector>

#include "convert/model.h"
#include "convert/sdf/sdf_scene.h"

namespace fire3dv::convert {

struct Prisms {
  std::vector<Surface> surfaces;  // one for each outline
  std::vector<std::string> notes;
};

// Prisms between z = 0 and the height of each outline. Polylines inside an outline are its holes, those
// inside a hole are outlines again; the first point may repeat at the end. No surfaces if a polyline or
// height is not finite, or has no extent. The time is the product of polylines and points.
Prisms prisms_of(const std::vector<SdfShape::Polyline>& lines);

}  // namespace fire3dv::convert
