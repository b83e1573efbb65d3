// Local files of Gazebo's meshes and textures: resolution of model://, package://, file:// and Fuel URIs and
// of paths. Nothing is downloaded.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "tools/convert/description_files.h"

namespace fire3dv::gazebo {

class Resources {
 public:
  // folders: searched first; contain models.
  explicit Resources(std::vector<std::filesystem::path> folders);
  // Adds the folders of GZ_SIM_RESOURCE_PATH, IGN_GAZEBO_RESOURCE_PATH and SDF_PATH, and the Fuel caches.
  static Resources from_environment(std::vector<std::filesystem::path> folders);

  // Returns an existing file. The error lists the folders that were tried, and the remedy.
  Result<std::filesystem::path> find(const std::string& uri) const;
  // Folders below which images may be read: those above, and the model of a file: the nearest folder at or
  // above it with a model.config.
  convert::AllowedFolders image_folders(const std::filesystem::path& file) const;

 private:
  std::vector<std::filesystem::path> folders_, fuel_caches_;
};

}  // namespace fire3dv::gazebo
