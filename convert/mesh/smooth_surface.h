// Surfaces without normals, made smooth over edges below an angle.
#pragma once

#include "convert/model.h"

namespace fire3dv::convert {

// The same surface with normals, which replace its own. Vertices of equal position are one vertex here; faces
// weigh by area and angle. least_cosine: as of corner_normals().
Surface with_normals(const Surface& surface, double least_cosine);

}  // namespace fire3dv::convert
