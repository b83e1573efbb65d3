// Binary cache file of a loaded scene and its derived data, for this build on this machine. Untrusted: reads
// validate everything and return either a valid scene or an error.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/edits/derived.h"
#include "renderer/scene/files.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct LoadedScene {
  Scene scene;
  Derived derived;
};

struct CachedScene {
  LoadedScene loaded;
  std::vector<SourceFile> sources;
};

// Format identifier at the start of each file; other builds have other identifiers.
Digest scene_file_format_id();

// Total bytes of all arrays, without names and other members.
uint64_t array_bytes(const LoadedScene& loaded);

// Writes atomically; concurrent writers of the same file are safe.
Result<void> write_scene_file(const std::filesystem::path& path, const LoadedScene& loaded,
                              const std::vector<SourceFile>& sources);

// Errors describe the fault without the file's name. read_scene_sources() reads the list of source files
// only.
Result<std::vector<SourceFile>> read_scene_sources(const std::filesystem::path& path);
Result<CachedScene> read_scene_file(const std::filesystem::path& path);

}  // namespace fire3dv::scene
