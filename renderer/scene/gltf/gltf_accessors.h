// Bounds-checked reader of glTF accessors. The whole byte range of an accessor is checked against its buffer
// view before the first read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/error.h"
#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {

// Bytes of a glTF component type; 0 if it is unknown.
size_t component_bytes(int component_type);

class AccessorReader {
 public:
  AccessorReader(const GltfDocument& document, const LoadLimits& limits)
      : document_(document), limits_(limits) {}

  // Number of elements. `where` names the referring object in errors.
  Result<size_t> count(int accessor, const std::string& where) const;

  // False for an accessor of zeros: without a buffer view and without sparse values.
  bool has_data(int accessor) const;

  // Calls LoadLimits::reserve; must precede the allocation.
  Result<void> reserve(uint64_t bytes, const std::string& where) const;
  bool stop_requested() const { return limits_.stop_requested && limits_.stop_requested(); }

  // Reads count() elements as floats, with integer conversion as the accessor defines. Element i is written
  // to first + i * stride_floats. An accessor with at least min_components leaves missing components
  // unchanged. Non-finite values are errors, or reported in is_finite if it is not null.
  Result<void> read_floats(int accessor, const std::string& where, float* first, size_t stride_floats,
                           int components, int min_components, bool* is_finite = nullptr) const;

  // Reads count() unsigned integers below `limit`.
  Result<void> read_indices(int accessor, const std::string& where, uint32_t* first, uint32_t limit) const;

 private:
  // Strided elements; data is null for all zeros.
  struct Elements {
    const std::byte* data = nullptr;
    size_t stride = 0;
    size_t count = 0;
    int component_type = 0;
    int components = 0;
    bool normalized = false;
  };
  Result<Elements> elements(const tinygltf::Accessor& accessor, const std::string& name) const;
  Result<Elements> packed(int buffer_view, int byte_offset, size_t count, int component_type, int components,
                          const std::string& name) const;
  template <typename Sink>
  Result<void> for_each_sparse(const tinygltf::Accessor& accessor, const Elements& base,
                               const std::string& name, Sink sink) const;

  const GltfDocument& document_;
  const LoadLimits& limits_;
};

}  // namespace fire3dv::scene
