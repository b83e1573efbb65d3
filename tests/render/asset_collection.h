// Public collections of glTF files, where they are at hand (FIRE3DV_ASSETS, or shared/assets beside the
// source tree), with what is known of each from elsewhere; and files made here, for where they are not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/gltf_builder.h"

namespace fire3dv::test {

struct CollectedAsset {
  std::string name;  // path within the collection
  std::filesystem::path path;
  bool faulty = false;                // by the expected report beside it, else by the validator
  std::optional<uint64_t> triangles;  // in its meshes, as the validator has counted
};

// By name. Empty where there is no collection.
std::vector<CollectedAsset> collected_assets();

// A folder of files that cover what collections show: textures, vertex colours, blending, skins and morph
// targets, lines, and the scenes of the gallery.
class MadeAssets {
 public:
  MadeAssets();
  const std::vector<CollectedAsset>& assets() const { return assets_; }

 private:
  void add(const std::string& name, std::span<const std::byte> bytes);

  ScratchFolder folder_;
  std::vector<CollectedAsset> assets_;
};

}  // namespace fire3dv::test
