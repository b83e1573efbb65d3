// Reads accessors into the loader's arrays. Every byte that an accessor reaches is checked to lie in its
// buffer view before the first one is read.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"

namespace fire3dv::scene {

class AccessorReader {
 public:
  AccessorReader(const GltfDocument& document, const LoadLimits& limits)
      : document_(document), limits_(limits) {}

  // How many elements the accessor holds; `where` names the object that refers to it.
  Result<size_t> count(int accessor, const std::string& where) const;

  // See LoadLimits: before room for so many bytes is made.
  Result<void> reserve(uint64_t bytes, const std::string& where) const;
  bool stop_requested() const { return limits_.stop_requested && limits_.stop_requested(); }

  // Reads count() elements as floats, integers converted as the accessor says. Element i goes to the
  // `components` floats at first + i * stride_floats. An accessor with fewer components than asked for but at
  // least `min_components` leaves the rest as it is. Values that are not finite are refused.
  Result<void> read_floats(int accessor, const std::string& where, float* first, size_t stride_floats,
                           int components, int min_components) const;

  // Reads count() unsigned integers below `limit` to `first`.
  Result<void> read_indices(int accessor, const std::string& where, uint32_t* first, uint32_t limit) const;

 private:
  // Elements at data, data + stride, ...; data is null where all are zero.
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
