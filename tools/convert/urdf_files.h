// Where a URDF leads: file:// URIs, paths beside it, and package:// URIs, which name a folder of a package.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::convert {

class UrdfFiles {
 public:
  // package_folders: hold packages, or are packages themselves. After them, the folders above the URDF are
  // looked at.
  UrdfFiles(const std::filesystem::path& urdf, const std::vector<std::filesystem::path>& package_folders);

  // A path, which need not exist. The error says what the URI is and what to do about it. Folders that a
  // package was looked for in and that are not there are added to `missing`.
  Result<std::filesystem::path> resolve(const std::string& uri,
                                        std::vector<std::filesystem::path>& missing) const;

 private:
  Result<std::filesystem::path> in_package(const std::string& name, const std::string& rest,
                                           std::vector<std::filesystem::path>& missing) const;

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> package_folders_;
};

}  // namespace fire3dv::convert
