// URI resolution for URDF: package://, model://, file:// and $(find PACKAGE) URIs, and paths relative to the
// description.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "convert/description_files.h"
#include "convert/model.h"
#include "convert/packages.h"

namespace fire3dv::convert {

// Decodes %20 and such.
std::string percent_decoded(const std::string& text);

class UrdfFiles {
 public:
  // package_folders: contain packages or are packages. is_confined: of a description of unknown origin: files
  // must lie below its folder, package_folders or installed packages, and nothing is searched above it.
  UrdfFiles(const std::filesystem::path& urdf, const std::vector<std::filesystem::path>& package_folders,
            bool is_confined, Sources& sources);

  // Returns a path, which need not exist. The error names the URI and the remedy. sources: receives the path
  // and missing package folders.
  //
  // A file of an unknown package, or one with the absolute path of another machine, is searched by the end of
  // its path in the folders above the description; take_notes() tells of it.
  Result<std::filesystem::path> resolve(const std::string& uri, Sources& sources);
  // Returns the folder of a package. A folder with a package.xml becomes an allowed folder.
  Result<std::filesystem::path> package(const std::string& name, Sources& sources);
  // Notes on guessed paths since the last call.
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

  // Folders for images: the URDF's, those that the user named, and packages with a package.xml: the URDF's
  // own and those it has referenced so far. Without package.xml, an untrusted URDF could declare any folder a
  // package, such as /home: then only a folder above the URDF with its meshes or images counts.
  const AllowedFolders& image_folders() const { return image_folders_; }

 private:
  Result<std::filesystem::path> find_readable(const std::string& uri, Sources& sources);
  Result<std::filesystem::path> find(std::string uri, Sources& sources);
  Result<std::filesystem::path> find_in_package(const std::string& package, const std::string& rest,
                                                const std::string& uri, Sources& sources);
  // Returns the path with the longest common end that exists in a folder above the description; empty if
  // there is none.
  std::filesystem::path find_by_end(const std::filesystem::path& path, size_t fewest_parts) const;
  bool is_own_folder(const std::filesystem::path& folder) const;
  bool allow_if_package(const std::filesystem::path& folder, Sources& sources);
  // Adds a note, one of each kind.
  void note(const std::string& kind, const std::string& sentence);

  std::filesystem::path folder_;
  std::optional<ReadableFolders> readable_;  // empty: all folders are
  Packages packages_;
  AllowedFolders image_folders_;
  std::set<std::string> noted_;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::convert
