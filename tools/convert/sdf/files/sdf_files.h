// URI resolution for SDF: model://, package://, file:// and Gazebo Fuel URIs, and paths relative to the file
// that names them. Nothing is downloaded.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "tools/convert/description_files.h"
#include "tools/convert/model.h"
#include "tools/convert/urdf/packages.h"

namespace fire3dv::convert {

class SdfFiles {
 public:
  // package_folders: contain models or packages, or are some. Reads GZ_SIM_RESOURCE_PATH,
  // IGN_GAZEBO_RESOURCE_PATH, SDF_PATH, GAZEBO_MODEL_PATH and GAZEBO_RESOURCE_PATH, and the places of Fuel's
  // cache: GZ_FUEL_CACHE_PATH, IGN_FUEL_CACHE_PATH, HOME. sources: receives every place that was looked at.
  SdfFiles(const std::filesystem::path& file, const std::vector<std::filesystem::path>& package_folders,
           Sources& sources);

  // Returns an existing file or folder. from: file that names the URI. The error names the URI, all folders
  // that were searched, and the remedy.
  Result<std::filesystem::path> resolve(const std::string& uri, const std::filesystem::path& from);

  // Folders for images: those of the description, of --package-path and of the variables, and of models and
  // packages (with a model.config or package.xml) of which a file was found.
  const AllowedFolders& image_folders() const { return image_folders_; }

 private:
  struct Folder {
    std::filesystem::path path;
    std::string origin;  // the variable; empty for --package-path
  };

  Result<std::filesystem::path> find(const std::string& uri, const std::filesystem::path& from);
  Result<std::filesystem::path> find_in_models(const std::string& below, const std::string& uri);
  Result<std::filesystem::path> find_in_fuel_cache(const std::string& uri);
  bool exists(const std::filesystem::path& path);
  void allow_model_of(const std::filesystem::path& path);
  std::string searched() const;

  std::filesystem::path folder_;
  std::vector<Folder> folders_;
  std::vector<std::filesystem::path> caches_;  // of Fuel
  Packages packages_;
  AllowedFolders image_folders_;
  Sources& sources_;
};

// File of a model folder that model.config names: that of the newest version up to `newest` (1.9 is 9), else
// of the newest.
Result<std::filesystem::path> sdf_of_model_folder(const std::filesystem::path& folder, unsigned newest,
                                                  Sources& sources);

}  // namespace fire3dv::convert
