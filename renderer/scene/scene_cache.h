// Scenes that were loaded before, and what was derived from them. A kept scene is found by what the asset's
// own file holds, and believed when the other files that it was made from hold what they held then.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/known_digests.h"
#include "renderer/scene/scene_file.h"

namespace fire3dv::scene {

struct SceneCacheSettings {
  enum class Place { nowhere, folder, beside_the_asset };
  Place place = Place::nowhere;
  std::filesystem::path folder;
  uint64_t most_bytes = uint64_t{4} << 30;         // in the folder; the least recently used go first
  uint64_t least_scene_bytes = uint64_t{1} << 20;  // smaller ones are read as fast from their own file
};

class SceneCache {
 public:
  explicit SceneCache(SceneCacheSettings settings) : settings_(std::move(settings)) {}

  // Without a sentence where nothing was kept; with one, in notes, where something was and cannot be used.
  std::optional<LoadedScene> find(const std::filesystem::path& asset, uint64_t max_file_bytes);
  // Nothing is done where nothing is to be won. The error names the file.
  Result<void> keep(const std::filesystem::path& asset, const LoadedScene& loaded,
                    const std::vector<SourceFile>& sources);

  // Of the asset that was looked for last and could be read.
  const StampedDigest* known() const { return known_ ? &*known_ : nullptr; }

  std::vector<std::string> take_notes() { return std::move(notes_); }

 private:
  std::filesystem::path place_of(const std::filesystem::path& asset, const Digest& own) const;

  SceneCacheSettings settings_;
  std::vector<std::string> notes_;
  KnownDigests digests_;  // of the asset that was looked for last and its files
  std::optional<StampedDigest> known_;
};

}  // namespace fire3dv::scene
