// The meshes of a model while it is read: those that are alike are kept once, since robots and scenes repeat
// themselves; and a few lines of a description cannot ask for more of them than there is memory for.
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
  // most_triangles: of all meshes that are kept; the one that reaches beyond them is the last.
  MeshStore(Model& model, size_t most_triangles) : model_(model), most_triangles_(most_triangles) {}

  bool is_full() const { return triangles_ > most_triangles_; }
  // Before each shape that is added to a mesh. False: it is to be left out.
  bool take_shape(const Mesh& so_far);
  std::string why_full() const;

  // Where the mesh is in the model: one with the same surfaces stands for it, whatever it is called. Nothing
  // for a mesh without surfaces.
  std::optional<size_t> keep(Mesh mesh);

 private:
  Model& model_;
  size_t most_triangles_, triangles_ = 0, shapes_ = 0;
  std::unordered_multimap<uint64_t, size_t> by_hash_;
};

}  // namespace fire3dv::convert
