// glTF 2.0 loader (.gltf, .glb). Untrusted bytes are validated before tinygltf, which parses memory only and
// opens no files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "base/error.h"
#include "renderer/scene/cache_files.h"
#include "renderer/scene/files.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct LoadLimits {
  uint64_t max_file_bytes = 4ull << 30;
  uint64_t max_image_pixels = 16384ull * 16384ull;
  uint32_t max_json_depth = 64;
  uint64_t max_decoded_image_bytes = UINT64_MAX;  // of all images; counted before they are decoded
  uint64_t max_elements = 1ull << 31;             // vertices or indices in one accessor
  uint64_t max_nodes = UINT32_MAX;                // including instances
  uint64_t max_path_bytes = 1ull << 30;           // of all nodes: paths repeat the names of all ancestors
  // Called with the size of each large allocation in advance, from any thread. An error aborts the load.
  std::function<Result<void>(uint64_t bytes)> reserve = {};
  // Polled between meshes and images, from any thread. Returning true aborts the load with an error.
  std::function<bool()> stop_requested = {};
};

// Called on the loading thread with stage ("images"), done and total.
using LoadProgress = std::function<void(const char* stage, size_t done, size_t total)>;

// Loads an asset; external files only from its folder or below. Errors name the file, the glTF object and the
// fault.
// sources: receives all files of the asset.
// known: recent digest of the asset's own file, or null.
Result<Scene> load_gltf(const std::filesystem::path& path, const LoadLimits& limits = {},
                        const LoadProgress& progress = {}, std::vector<SourceFile>* sources = nullptr,
                        const StampedDigest* known = nullptr);

// Loads a .glb from memory; it must not name other files. `name` identifies it in errors.
Result<Scene> load_glb(std::span<const std::byte> file, const std::string& name,
                       const LoadLimits& limits = {});

}  // namespace fire3dv::scene
