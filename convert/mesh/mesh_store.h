// Deduplication of meshes and vertices: a mesh store with a triangle limit, and a builder of surfaces with
// shared vertices. Scenes repeat meshes, and short descriptions may request more triangles than fit into
// memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "convert/model.h"

namespace fire3dv::convert {

// Deduplicating mesh store of a model.
class MeshStore {
 public:
  // max_triangles: limit of all stored meshes; the mesh that exceeds it is the last.
  MeshStore(Model& model, size_t max_triangles) : model_(model), max_triangles_(max_triangles) {}

  bool is_full() const { return triangles_ > max_triangles_; }
  // Call before each shape of a mesh. Returns false when the shape must be skipped.
  bool take_shape(const Mesh& so_far);
  std::string why_full() const;

  // Returns the index of the mesh in the model; an existing mesh with equal surfaces replaces it, whatever
  // its name. Empty for a mesh without surfaces.
  std::optional<size_t> add(Mesh mesh);

 private:
  Model& model_;
  size_t max_triangles_, triangles_ = 0, shapes_ = 0;
  std::unordered_multimap<uint64_t, size_t> by_hash_;
};

// Surface builder that adds triangles and shares bit-identical vertices.
class SurfaceBuilder {
 public:
  struct Corner {
    glm::vec3 position{0}, normal{0};
    glm::vec2 uv{0};
    glm::vec4 color{1};  // as in Surface
  };

  SurfaceBuilder(bool normals, bool uvs, bool colors = false)
      : normals_(normals), uvs_(uvs), colors_(colors) {}

  // Normals may have any length; the triangle's normal replaces zero or non-finite ones. Returns false,
  // without changes, for a non-finite position.
  bool add(const Corner& a, const Corner& b, const Corner& c);
  Surface take();

 private:
  uint32_t vertex(const Corner& corner);
  void grow();

  bool normals_, uvs_, colors_;
  Surface surface_;
  std::vector<uint32_t> table_;  // open addressing hash table: vertex + 1, 0 = free; power-of-two size
};

}  // namespace fire3dv::convert
