// Cache of loaded scenes with their derived data. The key is the digest of the asset file; an entry is valid
// while all other source files are unchanged, too. Entries are binary files for this build on this machine.
// Untrusted: reads validate everything and return either a valid scene or an error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/cache_files.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/files.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

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

struct SceneCacheSettings {
  enum class Place { nowhere, folder, beside_the_asset };
  Place place = Place::nowhere;
  std::filesystem::path folder;
  uint64_t max_bytes = uint64_t{4} << 30;  // limit of the folder; least recently used entries are evicted
  uint64_t least_scene_bytes = uint64_t{1} << 20;  // smaller scenes load as fast from their own file
};

class SceneCache {
 public:
  explicit SceneCache(SceneCacheSettings settings) : settings_(std::move(settings)) {}

  // Returns nullopt on a miss; an unusable entry adds a note.
  std::optional<LoadedScene> find(const std::filesystem::path& asset, uint64_t max_file_bytes);
  // Writes a cache entry, unless the scene is too small. The error names the file.
  Result<void> store(const std::filesystem::path& asset, const LoadedScene& loaded,
                     const std::vector<SourceFile>& sources);

  // Source files of the last scene that find() returned.
  const std::vector<SourceFile>& sources() const { return sources_; }
  // Digest of the last asset passed to find(), if it was readable.
  const StampedDigest* known() const { return known_ ? &*known_ : nullptr; }

  std::vector<std::string> take_log_messages() { return std::move(notes_); }

 private:
  std::filesystem::path place_of(const std::filesystem::path& asset, const Digest& own) const;

  SceneCacheSettings settings_;
  std::vector<std::string> notes_;
  DigestCache digests_;  // of the last asset and its files
  std::optional<StampedDigest> known_;
  std::vector<SourceFile> sources_;
};

}  // namespace fire3dv::scene
