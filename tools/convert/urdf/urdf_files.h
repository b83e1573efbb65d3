// URI resolution for URDF: file:// URIs, relative paths, and package:// URIs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "tools/convert/description_files.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

class UrdfFiles {
 public:
  // package_folders: contain packages or are packages. The parent folders of the URDF are searched
  // afterwards.
  UrdfFiles(const std::filesystem::path& urdf, const std::vector<std::filesystem::path>& package_folders,
            Sources& sources);

  // Returns a path, which need not exist. The error names the URI and the remedy. sources: receives the path
  // and missing package folders.
  Result<std::filesystem::path> resolve(const std::string& uri, Sources& sources);

  // Folders for images: the URDF's, those that the user named, and packages with a package.xml: the URDF's
  // own and those it has referenced so far. Without package.xml, an untrusted URDF could declare any folder a
  // package, such as /home.
  const AllowedFolders& image_folders() const { return image_folders_; }

 private:
  Result<std::filesystem::path> find(const std::string& uri, Sources& sources);
  Result<std::filesystem::path> package_folder(const std::string& name, Sources& sources);
  bool allow_if_package(const std::filesystem::path& folder, Sources& sources);

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> package_folders_;
  AllowedFolders image_folders_;
};

}  // namespace fire3dv::convert
