// Surface builder that adds triangles and shares bit-identical vertices.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "tools/convert/model.h"

namespace fire3dv::convert {

class SurfaceBuilder {
 public:
  struct Corner {
    glm::vec3 position{0}, normal{0};
    glm::vec2 uv{0};
  };

  SurfaceBuilder(bool normals, bool uvs) : normals_(normals), uvs_(uvs) {}

  // Normals may have any length; the triangle's normal replaces zero or non-finite ones. Returns false,
  // without changes, for a non-finite position.
  bool add(const Corner& a, const Corner& b, const Corner& c);
  Surface take();

 private:
  uint32_t vertex(const Corner& corner);
  void grow();

  bool normals_, uvs_;
  Surface surface_;
  std::vector<uint32_t> table_;  // open addressing hash table: vertex + 1, 0 = free; power-of-two size
};

}  // namespace fire3dv::convert
