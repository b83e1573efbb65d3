#include "examples/common/object_parts.h"

#include <algorithm>

namespace examples {

std::vector<Part> object_parts(const Object& object) {
  const Size& s = object.size;
  switch (object.shape) {
    case Shape::box: {
      const float least = std::min({s.x, s.y, s.z});
      return {{box_mesh({s.x, s.y, s.z}, std::min(0.22f * least, 0.006f)), object.material}};
    }
    case Shape::sphere:
      return {{capsule_mesh(s.x, 0, 48), object.material}};
    case Shape::capsule:
      return {{capsule_mesh(s.x, s.z), object.material}};
    case Shape::cylinder:
      break;
  }
  Part body{cylinder_mesh(s.x, s.z, std::min(0.12f * s.x, 0.2f * s.z)), object.material};
  if (object.mass_kg <= 0) return {body};
  // Can: a metal cylinder with a label sleeve half a millimetre thick.
  body.material = "brushed_metal";
  const bool teal = object.material == "painted_teal";
  return {body, {cylinder_mesh(s.x + 0.0005f, s.z * 0.74f, 0.0004f), teal ? "painted_teal" : "plastic_red"}};
}

}  // namespace examples
