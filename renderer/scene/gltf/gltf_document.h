// Parsed glTF file: tinygltf's model, and the bytes of buffers and images, which tinygltf never sees. Indices
// in the model are not validated here.
#pragma once

#include <tiny_gltf.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/cache/file_stamp.h"
#include "renderer/scene/files.h"
#include "renderer/scene/gltf/gltf_motion.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::scene {

struct ImageSource {
  std::string name;
  std::string uri;  // empty: the image is in a buffer view
  int buffer_view = -1;
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

}  // namespace fire3dv::scene
