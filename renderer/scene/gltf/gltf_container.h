// Text and BIN chunk of a glTF file (.gltf or .glb), before anything else is read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "base/error.h"
#include "base/files.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::scene {

struct GltfContainer {
  FileBytes file;
  std::string_view json;  // nested at most limits.max_json_depth deep
  std::span<const std::byte> binary;
  bool has_binary = false;
};
Result<GltfContainer> open_container(const std::filesystem::path& path, const LoadLimits& limits);

}  // namespace fire3dv::scene
