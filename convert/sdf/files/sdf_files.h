// URI resolution for SDF: model://, package://, file:// and Gazebo Fuel URIs, and paths relative to the file
// that names them. Nothing is downloaded.
//
// An absolute path that does not exist is another machine's, and is looked for by its end below the named
// folders.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "convert/description_files.h"
#include "convert/model.h"
#include "convert/packages.h"

namespace fire3dv::convert {

class SdfFiles {
 public:
  // package_folders: contain models or packages, or are some. Reads GZ_SIM_RESOURCE_PATH,
  // IGN_GAZEBO_RESOURCE_PATH, SDF_PATH, GAZEBO_MODEL_PATH and GAZEBO_RESOURCE_PATH, and the folders of Fuel's
  // cache: GZ_FUEL_CACHE_PATH, IGN_FUEL_CACHE_PATH, HOME. sources: receives every path that was tried.
  SdfFiles(const std::filesystem::path& file, const std::vector<std::filesystem::path>& package_folders,
           Sources& sources);
  // Of a running world or a description of unknown origin: whoever reaches the network may name paths, which
  // must lie below package_folders, those of the variables above,
  // ROS_PACKAGE_PATH, AMENT_PREFIX_PATH or Fuel's cache. folder_option: of the program's command line, for
  // messages. What was looked at is not recorded.
  // file: of the description, whose folder may be read; empty: there is none.
  SdfFiles(const std::vector<std::filesystem::path>& package_folders, std::string folder_option,
           const std::filesystem::path& file = {});

  // Returns an existing file or folder. from: file that names the URI; empty: none. The error names the URI,
  // all folders that were searched, and the remedy.
  Result<std::filesystem::path> resolve(const std::string& uri, const std::filesystem::path& from);

  // Folders for images: those of the description, of --package-path and of the variables, and of models and
  // packages (with a model.config or package.xml), also those of Fuel's cache, of which a file was found.
  const AllowedFolders& image_folders() const { return image_folders_; }
  // Why an image outside of them is left out, and the remedy.
  std::string outside_image_folders() const;

 private:
  struct Folder {
    std::filesystem::path path;
    std::string origin;  // the variable or option
  };

  void add_folders(const std::vector<std::filesystem::path>& package_folders);
  Result<std::filesystem::path> find(const std::string& uri, const std::filesystem::path& from);
  Result<std::filesystem::path> find_in_models(const std::string& below, const std::string& uri);
  std::optional<std::filesystem::path> find_above(const std::filesystem::path& path);
  std::optional<std::filesystem::path> find_by_end(const std::filesystem::path& path);
  Result<std::filesystem::path> find_in_fuel_cache(const std::string& uri);
  std::optional<std::filesystem::path> find_model_in_fuel_cache(const std::string& model,
                                                                const std::filesystem::path& below);
  bool exists(const std::filesystem::path& path);
  // The absolute path may be read, whether it exists or not.
  bool is_readable(const std::filesystem::path& path) const { return !readable_ || readable_->hold(path); }
  void allow_model_of(const std::filesystem::path& path);
  std::string searched() const;

  std::filesystem::path folder_;  // of the file; empty: none
  std::string option_ = "--package-path";
  std::vector<Folder> folders_;
  std::vector<std::filesystem::path> caches_;  // of Fuel
  Packages packages_;
  AllowedFolders image_folders_;
  std::optional<ReadableFolders> readable_;  // empty: all absolute paths are
  Sources* sources_ = nullptr;
  size_t missing_ = 0;  // files that were not found: a search for one looks into many folders
};

// File of a model folder that model.config names: that of the newest version up to `newest` (1.9 is 9), else
// of the newest.
Result<std::filesystem::path> sdf_of_model_folder(const std::filesystem::path& folder, unsigned newest,
                                                  Sources& sources);

}  // namespace fire3dv::convert
