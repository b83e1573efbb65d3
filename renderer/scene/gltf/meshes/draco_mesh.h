// Decoder of Draco meshes from untrusted files, by libdraco. The caller limits its memory before it is
// allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "base/error.h"
#include "renderer/scene/gltf/meshes/draco_header.h"

namespace draco {
class Mesh;
}

namespace fire3dv::scene {

class DracoMesh {
 public:
  // reserve: called with the bytes of the connectivity and of each attribute before they are allocated; an
  // error stops the decoder and is returned. No exception leaves the function.
  static Result<DracoMesh> decode(const DracoHeader& header,
                                  const std::function<Result<void>(uint64_t bytes)>& reserve);

  DracoMesh(DracoMesh&& other) noexcept;
  DracoMesh& operator=(DracoMesh&& other) noexcept;
  ~DracoMesh();

  size_t face_count() const;
  size_t point_count() const;

  // Three indices per face; they are not compared with point_count().
  void copy_indices(uint32_t* to) const;

  // Packed values of an attribute for all points, in glTF's component type. Components must be as many as in
  // the stream. Integers and floats are converted as the stream's attribute defines.
  Result<void> copy_attribute(uint32_t unique_id, int component_type, int components, std::byte* to) const;

 private:
  explicit DracoMesh(std::unique_ptr<draco::Mesh> mesh);
  std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace fire3dv::scene
