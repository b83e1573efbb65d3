// Parsed glTF file: tinygltf's model, and the bytes of buffers and images, which tinygltf never sees. With
// the steps before and after tinygltf (gltf_schema.cpp, gltf_meshopt.cpp).
#pragma once

#include <tiny_gltf.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/cache_files.h"
#include "renderer/scene/files.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::scene {

// Skins and animations of a glTF file, parsed directly from the JSON. Unchecked indices of the file; -1:
// missing.
struct SkinSource {
  std::string name;
  std::vector<int> joints;
  int inverse_bind_matrices = -1;
};

struct AnimationSource {
  struct Sampler {
    int input = -1, output = -1;
    std::string interpolation;
  };
  struct Channel {
    int sampler = -1, node = -1;
    std::string path;
  };
  std::string name;
  std::vector<Sampler> samplers;
  std::vector<Channel> channels;
};

struct ImageSource {
  std::string name;
  std::string uri;
  int buffer_view = -1;  // precedes the uri; -1: none
};

struct GltfDocument {
  tinygltf::Model model;                            // without buffers, images, skins and animations
  std::vector<std::span<const std::byte>> buffers;  // of the declared length; empty: placeholder
  std::vector<ImageSource> images;
  std::vector<SkinSource> skins;
  std::vector<AnimationSource> animations;
  AssetFolder folder;
  std::vector<std::string> warnings;
  std::vector<FileBytes> owned;  // storage of the buffers
};

Result<GltfDocument> open_gltf(const std::filesystem::path& path, const LoadLimits& limits,
                               std::vector<SourceFile>* sources, const StampedDigest* known = nullptr);

// Reads a .glb from memory; it must not name other files.
Result<GltfDocument> read_glb(std::span<const std::byte> bytes, const LoadLimits& limits);

// Bytes of a buffer view. `where` names the referring object in errors.
Result<std::span<const std::byte>> buffer_view_bytes(const GltfDocument& document, int buffer_view,
                                                     const std::string& where);

// Example: "meshes[3]".
inline std::string element(const char* array, size_t index) {
  return std::string(array) + "[" + std::to_string(index) + "]";
}

// True if `index` is valid for an array of this size.
inline bool in_range(int index, size_t size) {
  return index >= 0 && static_cast<size_t>(index) < size;
}

// Clamps a JSON number to the range of float.
inline float to_float(double number) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(number, -kLargest, kLargest));
}

inline Error out_of_range(const std::string& where, const char* array, int index, size_t size) {
  return Error{where + " refers to " + array + "[" + std::to_string(index) + "], but there are " +
               std::to_string(size)};
}

// JSON schema check for glTF before tinygltf. tinygltf ignores members of a wrong type, truncates integers
// and keeps unknown members. Here wrong types are errors that name the member, and unknown members are
// removed.
//
// True for extensions that the loader implements.
bool extension_supported(const std::string& name);

// Validates and reduces the document in place. Warnings name removed parts.
Result<void> check_and_reduce(nlohmann::json& document, std::vector<std::string>& warnings);

// KHR_meshopt_compression, EXT_meshopt_compression: decodes each compressed buffer view into a new buffer and
// redirects the view to it. Later stages see plain buffer views and never read fallback buffers. Requires the
// document's buffers.
Result<void> decompress_buffer_views(nlohmann::json& root, const LoadLimits& limits, GltfDocument& document);

// KHR_draco_mesh_compression: decodes compressed primitives and redirects them to new accessors of the
// decoded arrays. A primitive that cannot be decoded keeps its uncompressed accessors, with a warning;
// without such it is an error. Later stages see plain primitives. Requires the document's buffers.
Result<void> decompress_draco_primitives(nlohmann::json& root, const LoadLimits& limits,
                                         GltfDocument& document);

// True if the buffer is a fallback of the extension; its bytes may be missing.
bool is_meshopt_fallback(const nlohmann::json& buffer);

}  // namespace fire3dv::scene
