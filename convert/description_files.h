// Untrusted files of descriptions: access control, detection of formats by content, and guards for the XML
// parsers that read them afterwards. Those parsers recurse once per nested element.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/files.h"

namespace fire3dv::convert {

// Access control for files that a description references. Paths are untrusted: targets must be regular files
// of a real file system. Where a folder limits access, symbolic links cannot leave it.

// Returns the path with resolved links. Refuses anything but regular files, and kernel file systems (/proc,
// /sys, /dev). The error names the path and the reason.
Result<std::filesystem::path> regular_file(const std::filesystem::path& path);

// The error of a pointer that Git LFS left instead of the file: it says how to fetch the file. Nothing for
// others.
std::optional<Error> git_lfs_pointer(const std::filesystem::path& file);
// Reads a file that a description names; a pointer of Git LFS is an error.
Result<FileBytes> read_asset(const std::filesystem::path& file, uint64_t max_bytes);

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

enum class DescriptionKind { adf, urdf, mjcf, sdf };

// Reads a description file of at most 64 MiB.
Result<std::string> read_text(const std::filesystem::path& file);

// The error names the file and, where known, its real format (xacro, glTF).
Result<DescriptionKind> kind_of(const std::filesystem::path& file, std::string_view text);

// The text without ends of <mujoco> behind the last one that is needed: MuJoCo reads a model whose root ends
// twice.
std::string_view without_extra_ends(std::string_view text);

// Returns the name of the root element. Refuses more than 100 nested elements, 1000 attributes of one, entity
// definitions and constructs that parsers read differently. Empty: not XML. The error names the line.
Result<std::string> xml_root(std::string_view text);

}  // namespace fire3dv::convert
