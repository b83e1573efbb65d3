// Which files of this machine a description may lead to. A path may be written by a stranger: what is reached
// must be a regular file of a real file system, and where a folder bounds it, links do not lead out of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::convert {

// The file's own path, links resolved: a regular file, and none that the kernel makes up (/proc, /sys, /dev).
// The error says why not, and names the path.
Result<std::filesystem::path> regular_file(const std::filesystem::path& path);

// Without the parts that say nothing ("."), for messages. ".." stays: behind a link it leads elsewhere.
std::filesystem::path tidy_path(const std::filesystem::path& path);

// Folders below which files may be read.
class AllowedFolders {
 public:
  // A folder that does not exist allows nothing. The file system's root neither: it would allow everything.
  void add(const std::filesystem::path& folder);
  void add(const AllowedFolders& others);
  // `resolved` as regular_file gives it.
  bool hold(const std::filesystem::path& resolved) const;

 private:
  std::vector<std::filesystem::path> folders_;  // links resolved
};

}  // namespace fire3dv::convert
