// Primitives of a glTF document that KHR_draco_mesh_compression compresses, grouped by Draco stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::scene {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

// Attribute of a stream that an accessor describes.
struct DracoAttribute {
  std::string name;
  uint32_t unique_id = 0;
  size_t accessor = 0;
  int component_type = 0, components = 0;
  size_t packed_bytes = 0;  // of one element
  auto operator<=>(const DracoAttribute&) const = default;
};

// Decoded arrays: indices, then the attributes one after the other, each at a multiple of four bytes.
struct DracoArrays {
  FileBytes bytes;
  size_t faces = 0, points = 0;
};

// A compressed primitive.
struct DracoPrimitive {
  nlohmann::json* primitive = nullptr;
  std::string where;
  std::vector<DracoAttribute> attributes;
  uint64_t max_faces = 0, max_points = 0;  // by the accessors
  std::optional<size_t> same_as;           // an earlier use of the stream with the same attributes
  std::optional<Error> fault;
  DracoArrays arrays;  // valid without a fault
};

struct DracoStream {
  size_t view = 0;
  std::vector<DracoPrimitive> uses;
};

// Streams in the order of their first use. A primitive that contradicts the extension has a fault. The
// document's JSON must outlive the result, and its meshes must not change.
std::vector<DracoStream> draco_streams(nlohmann::json& root, const LoadLimits& limits);

// An element of a root array, or null.
const nlohmann::json* element_at(const nlohmann::json& root, const char* array, size_t index);

}  // namespace fire3dv::scene
