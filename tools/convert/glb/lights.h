// Helpers for lights of description files.
#pragma once

#include "tools/convert/model.h"

namespace fire3dv::convert {

// Rotation from -Z, the direction of glTF lights, to `direction`, which must not be 0.
glm::dquat shining(const glm::dvec3& direction);

// Adds a directional light to a model without lights, from above and from the side of a viewer at +X, -Y.
// Without shadows, depth is hard to judge. A directional light suits every scene size.
void add_light_if_none(Model& model);

}  // namespace fire3dv::convert
