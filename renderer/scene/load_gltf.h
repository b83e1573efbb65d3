// glTF 2.0 (.gltf, .glb) to Scene. Bytes from outside are checked before tinygltf sees them; tinygltf gets
// memory only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "protocol/error.h"
#include "renderer/scene/file_stamp.h"
#include "renderer/scene/files.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

struct LoadLimits {
  uint64_t max_file_bytes = 4ull << 30;
  uint64_t max_image_pixels = 16384ull * 16384ull;
  uint32_t max_json_depth = 64;
  uint64_t max_elements = 1ull << 31;    // vertices or indices in one accessor
  uint64_t max_nodes = UINT32_MAX;       // instances included
  uint64_t max_path_bytes = 1ull << 30;  // of all nodes: paths repeat the names of all ancestors
  // Called with the bytes of each large allocation before it is made, from any thread. An error ends the
  // load.
  std::function<Result<void>(uint64_t bytes)> reserve = {};
  // Polled between meshes and between images, from any thread. True ends the load with an error.
  std::function<bool()> stop_requested = {};
};

// Called now and then from the calling thread while loading: stage ("images"), done, total.
using LoadProgress = std::function<void(const char* stage, size_t done, size_t total)>;

// The error names the file, the glTF object and what is wrong with it. External files are read only from the
// asset's folder or below. sources: gets the files that the asset consists of.
// known: what its own file held shortly before, if that is known.
Result<Scene> load_gltf(const std::filesystem::path& path, const LoadLimits& limits = {},
                        const LoadProgress& progress = {}, std::vector<SourceFile>* sources = nullptr,
                        const StampedDigest* known = nullptr);

// The same for a whole .glb in memory, which names no other files. `name` stands for it in errors.
Result<Scene> load_glb(std::span<const std::byte> file, const std::string& name,
                       const LoadLimits& limits = {});

}  // namespace fire3dv::scene
