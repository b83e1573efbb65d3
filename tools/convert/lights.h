// What readers of descriptions say of lights alike.
#pragma once

#include "tools/convert/model.h"

namespace fire3dv::convert {

// A rotation that turns -Z, where glTF's lights shine, into the direction, which is not 0.
glm::dquat shining(const glm::dvec3& direction);

// A description without lights gets one, from above and from the side of a viewer who stands at +X and -Y:
// without shadows it is hard to see where things are. Directional, so that the size of the scene does not
// matter.
void add_light_if_none(Model& model);

}  // namespace fire3dv::convert
