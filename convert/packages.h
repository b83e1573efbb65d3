// Finder of ROS packages by name: folders that the user names, the description's own package and its
// neighbours, then the folders of ROS's environment variables.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "convert/model.h"

namespace fire3dv::convert {

// The <name> of folder/package.xml; empty without one. sources receives the file.
std::string package_name(const std::filesystem::path& folder, Sources& sources);

// Folders of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH: the user's installed packages.
std::vector<std::filesystem::path> installed_package_folders();

// Folders below which a description of unknown origin may name files. Paths are compared as they are written:
// links below a folder may lead out of it, as those of colcon's workspaces do, since whoever made them owns
// the folder.
class ReadableFolders {
 public:
  explicit ReadableFolders(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

  // Whether the file exists or not. A path with ".." lies below none.
  bool hold(const std::filesystem::path& path) const;

 private:
  std::vector<std::filesystem::path> folders_;
};

class Packages {
 public:
  // description_folder: resolved; empty: there is none. named: contain packages at any depth, or are
  // packages. Reads ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
  Packages(const std::filesystem::path& description_folder, const std::vector<std::filesystem::path>& named);

  // Returns the folder of the package, in this order: named folders; folders above the description that are
  // the package, by <name> or folder name, or contain it; packages beside the description's own;
  // ROS_PACKAGE_PATH; share/NAME of AMENT_PREFIX_PATH. sources receives what was looked at.
  Result<std::filesystem::path> find(const std::string& name, Sources& sources);

  // The nearest folder at or above the description with a package.xml, if any.
  std::optional<std::filesystem::path> own_package(Sources& sources) const;

 private:
  using Index = std::map<std::string, std::filesystem::path>;

  // Packages at or below a folder by their <name>. Does not descend into packages. Each folder is searched
  // once, and all searches together visit a limited number of folders.
  const Index& index_of(const std::filesystem::path& folder, int depth, Sources& sources);
  std::optional<std::filesystem::path> find_in(const std::vector<std::filesystem::path>& folders,
                                               const std::string& name, Sources& sources);
  std::optional<std::filesystem::path> find_above(const std::string& name, Sources& sources);

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> named_, ros_folders_, ament_prefixes_;
  std::map<std::filesystem::path, Index> indices_;
  size_t visited_ = 0;
};

}  // namespace fire3dv::convert
