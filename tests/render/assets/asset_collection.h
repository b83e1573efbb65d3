// Public glTF collections (FIRE3DV_ASSETS, or shared/assets beside the source tree) with the glTF validator's
// result for each file. Generated files cover the same features without them.
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
  bool faulty = false;                // by the expected report beside the file, else by the validator
  std::optional<uint64_t> triangles;  // in its meshes, as counted by the validator
};

// Returns the assets sorted by name. Empty without a collection.
std::vector<CollectedAsset> collected_assets();

// A folder of generated files that cover the collections' features: textures, vertex colours, blending,
// skins, morph targets, lines, and the gallery scenes.
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
