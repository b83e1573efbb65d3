// Elements that a composite makes, and its settings.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <vector>

#include "convert/mjcf/deformable/composite.h"

namespace fire3dv::convert {

class CompositeParts {
 public:
  CompositeParts(const MjcfAttributes& from, std::string body);

  MjcfElement element(const char* kind, const std::string& name) const;
  MjcfElement body(const std::string& name, const glm::dvec3& position, const glm::dquat& rotation) const;
  // With the attributes of the composite's own geom element.
  MjcfElement geom(const std::string& name, const std::string& type, const glm::dvec3& size,
                   const glm::dvec3& position, const glm::dquat& rotation) const;
  MjcfElement joint(const char* type, const std::string& name, const glm::dvec3& position,
                    const glm::dvec3& axis) const;
  MjcfElement site(const std::string& name, const glm::dvec3& position) const;

  bool has_joint(const char* kind) const;
  const MjcfElement* child(const char* kind) const;

  const MjcfAttributes& from;
  std::string parent, prefix, type;
  std::array<int, 3> count{1, 1, 1};
  int dimensions = 0;  // counts above 1, which come first
  std::string geom_type;
  glm::dvec3 geom_size{0};
  bool shows_geoms = true;
};

// Children of a body for one kind of composite each. The error is a sentence end about the element.
Result<void> expand_cable(const CompositeParts& parts, Composite& to);
Result<void> expand_particles(const CompositeParts& parts, Composite& to);  // particle, grid
Result<void> expand_rope(const CompositeParts& parts, Composite& to);       // rope, loop
Result<void> expand_cloth(const CompositeParts& parts, Composite& to);
Result<void> expand_shell(const CompositeParts& parts, Composite& to);  // box, cylinder, ellipsoid

// Two-sided sheet over a grid of bones. bone: of a position in the grid; poses are those of a body at the
// origin.
struct SheetBone {
  std::string body;
  glm::dvec3 position{0};  // of the vertex in the frame of the body
};
SkinData sheet_skin(int columns, int rows, const std::vector<SheetBone>& bones);

}  // namespace fire3dv::convert
