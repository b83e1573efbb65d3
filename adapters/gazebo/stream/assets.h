// Background conversion of models that appear while the world runs, so that poses go on meanwhile.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "adapters/gazebo/world/entities.h"
#include "base/error.h"

namespace fire3dv::gazebo {

struct ConvertedAsset {
  std::string node;  // TopLevel::added_node
  Result<std::vector<std::byte>> glb = std::vector<std::byte>();
  std::vector<std::string> warnings;
};

// Converts items to one .glb file. name: of its root node. has_default_light: adds a light if the items have
// none. resource_folders: as of scene_model().
ConvertedAsset convert_items(const std::vector<TopLevel>& items,
                             const std::vector<std::filesystem::path>& resource_folders,
                             const std::string& name, bool has_default_light);

class AssetQueue {
 public:
  explicit AssetQueue(std::vector<std::filesystem::path> resource_folders)
      : resource_folders_(std::move(resource_folders)) {}
  ~AssetQueue();

  // Items with equal added_node names are one asset.
  void push(std::vector<TopLevel> items);
  // Returns a finished asset once.
  std::optional<ConvertedAsset> take();

 private:
  void start();

  const std::vector<std::filesystem::path> resource_folders_;
  std::deque<std::vector<TopLevel>> waiting_;
  std::future<ConvertedAsset> running_;
};

}  // namespace fire3dv::gazebo
