// A loaded scene and what is derived from it as one file of our own: read at the speed of memory, by this
// program on this machine. It comes from outside like any other file: whatever it holds, what is read from it
// is right, or refused.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/derived.h"
#include "renderer/scene/files.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

struct LoadedScene {
  Scene scene;
  Derived derived;
};

struct KeptScene {
  LoadedScene loaded;
  std::vector<SourceFile> sources;
};

// What a file of this program begins with: another build's files are of another kind.
Digest scene_file_kind();

// All bytes that the arrays hold, without textures' names and the like.
uint64_t array_bytes(const LoadedScene& loaded);

// Whole or not at all, beside others who write the same.
Result<void> write_scene_file(const std::filesystem::path& path, const LoadedScene& loaded,
                              const std::vector<SourceFile>& sources);

// The error says what is wrong with the file, without its name. The first one reads only what the scene was
// made from.
Result<std::vector<SourceFile>> read_scene_sources(const std::filesystem::path& path);
Result<KeptScene> read_scene_file(const std::filesystem::path& path);

}  // namespace fire3dv::scene
