// Deduplicating mesh store of a model, with a triangle limit: scenes repeat meshes, and short descriptions
// may request more triangles than fit into memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>

#include "tools/convert/model.h"

namespace fire3dv::convert {

class MeshStore {
 public:
  // most_triangles: limit of all stored meshes; the mesh that exceeds it is the last.
  MeshStore(Model& model, size_t most_triangles) : model_(model), most_triangles_(most_triangles) {}

  bool is_full() const { return triangles_ > most_triangles_; }
  // Call before each shape of a mesh. Returns false when the shape must be skipped.
  bool take_shape(const Mesh& so_far);
  std::string why_full() const;

  // Returns the index of the mesh in the model; an existing mesh with equal surfaces replaces it, whatever
  // its name. Empty for a mesh without surfaces.
  std::optional<size_t> add(Mesh mesh);

 private:
  Model& model_;
  size_t most_triangles_, triangles_ = 0, shapes_ = 0;
  std::unordered_multimap<uint64_t, size_t> by_hash_;
};

}  // namespace fire3dv::convert
