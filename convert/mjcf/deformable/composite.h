// Expansion of MuJoCo's composite elements to bodies, joints and geoms: cables, and those that MuJoCo 2.2 has
// and MuJoCo 3 replaced.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "convert/mjcf/deformable/skin_data.h"
#include "convert/mjcf/xml/mjcf_attributes.h"
#include "convert/mjcf/xml/mjcf_element.h"

namespace fire3dv::convert {

struct Composite {
  std::vector<MjcfElement> children;  // of the body that holds the element; orientations are quaternions
  std::optional<SkinData> skin;       // bones are named as in the children
  double inflation = 0;
  std::string note;  // sentence end about what differs, or ""
};

// body: name of the body that holds the element. At most 100,000 bodies, and 1000 in a chain. The error is a
// sentence end about the element.
Result<Composite> expand_composite(const MjcfAttributes& from, const std::string& body);

}  // namespace fire3dv::convert
