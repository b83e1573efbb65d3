// Where a URDF leads: file:// URIs, paths beside it, and package:// URIs, which name a folder of a package.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/local_files.h"
#include "tools/convert/sources.h"

namespace fire3dv::convert {

class UrdfFiles {
 public:
  // package_folders: hold packages, or are packages themselves. After them, the folders above the URDF are
  // looked at.
  UrdfFiles(const std::filesystem::path& urdf, const std::vector<std::filesystem::path>& package_folders,
            Sources& sources);

  // A path, which need not exist. The error says what the URI is and what to do about it. `sources` gets it,
  // and where a package was looked for in vain.
  Result<std::filesystem::path> resolve(const std::string& uri, Sources& sources);

  // Where images may lie: the URDF's folder, those that the user has named, and packages, by their
  // package.xml: that in which the URDF lies, and those that it has named so far. A stranger's URDF may call
  // any folder a package, such as the one that holds everybody's home.
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
