// Access control for files that a description references. Paths are untrusted: targets must be regular files
// of a real file system. Where a folder limits access, symbolic links cannot leave it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/base/error.h"

namespace fire3dv::convert {

// Returns the path with resolved links. Refuses anything but regular files, and kernel file systems (/proc,
// /sys, /dev). The error names the path and the reason.
Result<std::filesystem::path> regular_file(const std::filesystem::path& path);

// Removes "." components, for messages. ".." stays, since its meaning depends on symbolic links.
std::filesystem::path tidy_path(const std::filesystem::path& path);

// Folders below which files may be read.
class AllowedFolders {
 public:
  // Ignores missing folders and the root folder, which would allow everything.
  void add(const std::filesystem::path& folder);
  void add(const AllowedFolders& others);
  // resolved: result of regular_file().
  bool hold(const std::filesystem::path& resolved) const;

 private:
  std::vector<std::filesystem::path> folders_;  // resolved paths
};

}  // namespace fire3dv::convert
