// Triangles corner by corner, to a surface whose vertices are shared wherever they are bitwise the same.
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

  // Normals of any length; where one is none, the triangle's own takes its place. False, and nothing is
  // added: a position is not finite.
  bool add(const Corner& a, const Corner& b, const Corner& c);
  Surface take();

 private:
  uint32_t vertex(const Corner& corner);
  void grow();

  bool normals_, uvs_;
  Surface surface_;
  std::vector<uint32_t> table_;  // open addressing: vertex + 1, 0 is free; a power of two of places
};

}  // namespace fire3dv::convert
