// Files of the assets that added nodes name, and keys of loaded assets. One thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/digest.h"
#include "base/error.h"
#include "renderer/scene/cache_files.h"
#include "renderer/scene/files.h"
#include "renderer/state/edits/edit_registry.h"

namespace fire3dv::app {

bool has_asset(const state::RequestedNode& node);
std::string asset_name(const state::RequestedNode& node);  // for messages

// File that a node was added with, in the merged scene: its nodes follow that node.
struct MergedAsset {
  std::filesystem::path file = {};
  uint32_t node_count = 0;
  uint32_t first_material = 0, material_count = 0;  // of the scene, with its default material
  Digest digest{};                                  // of the file itself
};

// Files of an asset as they were when it was read, by their stamps.
class ReadFiles {
 public:
  ReadFiles() = default;  // without files, such as an embedded asset: unchanged
  // Begin of a read of this asset.
  explicit ReadFiles(const std::filesystem::path& asset);
  // End of the read. sources: of load_gltf().
  void finish(const std::vector<scene::SourceFile>& sources);

  // False also if one of the files was missing.
  bool are_unchanged() const;
  bool empty() const { return files_.empty(); }
  const Digest& digest() const { return digest_; }  // of the asset's own file

 private:
  std::map<std::filesystem::path, scene::FileStamp> files_;
  std::filesystem::path asset_;
  Digest digest_{};
  bool lacks_file_ = false;
};

class AssetFiles {
 public:
  // folder: root of the assets; empty: none. overlay: file of the user's additions; empty: none.
  AssetFiles(std::filesystem::path folder, std::filesystem::path overlay)
      : folder_(std::move(folder)), overlay_(std::move(overlay)) {}

  // URIs are relative to the root of the assets; the user's first to the folder of the overlay file.
  Result<std::filesystem::path> find(const std::string& uri, bool is_of_user) const;
  // Nodes with equal keys share one loaded asset. URIs by which the user names one file have one key.
  std::string key(const state::RequestedNode& node);
  // The next key() looks again for files that were not found. Keys of found files stay.
  void forget_missing();
  void clear() { paths_.clear(); }

 private:
  const std::filesystem::path folder_, overlay_;
  std::map<std::string, std::filesystem::path> paths_;  // by URI of the user; empty: not found
};

}  // namespace fire3dv::app
