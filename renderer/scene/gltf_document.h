// A glTF file, read and parsed: the model as tinygltf sees it, and the bytes of its buffers and images, which
// tinygltf never sees. Indices in the model are not checked yet: whoever follows one checks it.
#pragma once

#include <tiny_gltf.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/file_stamp.h"
#include "renderer/scene/files.h"
#include "renderer/scene/gltf_motion.h"
#include "renderer/scene/load_gltf.h"

namespace fire3dv::scene {

struct ImageSource {
  std::string name;
  std::string uri;  // empty: the image lies in a buffer view
  int buffer_view = -1;
};

struct GltfDocument {
  tinygltf::Model model;                            // without buffers, images, skins and animations
  std::vector<std::span<const std::byte>> buffers;  // of the declared length; empty: it names no bytes
  std::vector<ImageSource> images;
  std::vector<SkinSource> skins;
  std::vector<AnimationSource> animations;
  AssetFolder folder;
  std::vector<std::string> warnings;
  std::vector<Bytes> owned;  // what the buffers look into
};

Result<GltfDocument> open_gltf(const std::filesystem::path& path, const LoadLimits& limits,
                               std::vector<SourceFile>* sources, const StampedDigest* known = nullptr);

// A .glb in memory, which names no other files.
Result<GltfDocument> read_glb(std::span<const std::byte> bytes, const LoadLimits& limits);

// The bytes of a buffer view; `where` names the object that refers to it.
Result<std::span<const std::byte>> buffer_view_bytes(const GltfDocument& document, int buffer_view,
                                                     const std::string& where);

// "meshes[3]"
inline std::string element(const char* array, size_t index) {
  return std::string(array) + "[" + std::to_string(index) + "]";
}

// Whether `index` may be used on an array of this size.
inline bool in_range(int index, size_t size) {
  return index >= 0 && static_cast<size_t>(index) < size;
}

// JSON's numbers are doubles; those beyond float's range become its largest.
inline float to_float(double number) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(number, -kLargest, kLargest));
}

inline Error out_of_range(const std::string& where, const char* array, int index, size_t size) {
  return Error{where + " refers to " + array + "[" + std::to_string(index) + "], but there are " +
               std::to_string(size)};
}

}  // namespace fire3dv::scene
