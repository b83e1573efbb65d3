#include "convert/urdf_files.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

bool begins_with_scheme(const std::string& uri) {
  const size_t mark = uri.find("://");
  return mark != std::string::npos && mark < uri.find('/');
}

}  // namespace

std::string percent_decoded(const std::string& text) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    unsigned code = 0;
    const char* digits = text.data() + i + 1;
    if (text[i] == '%' && i + 2 < text.size() &&
        std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2 && code >= 0x20) {
      decoded += static_cast<char>(code);
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

namespace {

std::string without_leading_slashes(const std::string& text) {
  return text.substr(std::min(text.find_first_not_of('/'), text.size()));
}

fs::path folder_of(const fs::path& urdf) {
  std::error_code error;
  const fs::path file = fs::canonical(urdf, error);
  return error ? fs::absolute(urdf).parent_path() : file.parent_path();
}

}  // namespace

UrdfFiles::UrdfFiles(const fs::path& urdf, const std::vector<fs::path>& package_folders, bool is_confined,
                     Sources& sources)
    : folder_(folder_of(urdf)), packages_(is_confined ? fs::path() : folder_, package_folders) {
  if (is_confined) {
    std::vector<fs::path> readable = installed_package_folders();
    readable.push_back(folder_);
    readable.insert(readable.end(), package_folders.begin(), package_folders.end());
    readable_.emplace(std::move(readable));
  }
  image_folders_.add(folder_);
  image_folders_.add(urdf.parent_path());  // folder of the symbolic link
  for (const fs::path& folder : package_folders) image_folders_.add(folder);
  if (is_confined) return;
  if (const std::optional<fs::path> own = packages_.own_package(sources)) image_folders_.add(*own);
}

Result<fs::path> UrdfFiles::resolve(const std::string& uri, Sources& sources) {
  if (uri.empty()) return Error{"it names no file"};
  if (uri.find('\0') != std::string::npos) return Error{quote(uri) + " holds a zero byte"};
  Result<fs::path> path = find_readable(uri, sources);
  if (!path) return path;
  sources.add(*path);
  // Names of other systems, tried only where the literal name does not exist.
  std::string other = percent_decoded(uri);
  std::replace(other.begin(), other.end(), '\\', '/');
  if (other == uri || regular_file(*path)) return path;
  const Result<fs::path> second = find_readable(other, sources);
  if (!second || !regular_file(*second)) return path;
  sources.add(*second);
  return second;
}

// What lies outside is refused whether it exists or not.
Result<fs::path> UrdfFiles::find_readable(const std::string& uri, Sources& sources) {
  Result<fs::path> path = find(uri, sources);
  if (!path || !readable_ || readable_->hold(*path)) return path;
  return Error{quote(uri) +
               " lies outside the folders that a description of unknown origin may name files of: name its "
               "folder with --package-path"};
}

Result<fs::path> UrdfFiles::package(const std::string& name, Sources& sources) {
  const bool is_name = name.find_first_of(std::string_view("/\0", 2)) == std::string::npos;
  if (name.empty() || name == "." || name == ".." || !is_name)
    return Error{quote(name) + " is not a name of a package"};
  Result<fs::path> folder = packages_.find(name, sources);
  if (folder) allow_if_package(*folder, sources);
  return folder;
}

// A copied package without package.xml: a folder above the description with folders of its meshes or images.
// Other folders of that name, such as /home, are none.
bool UrdfFiles::is_own_folder(const fs::path& folder) const {
  std::error_code error;
  const fs::path resolved = fs::canonical(folder, error);
  const fs::path below = folder_.lexically_relative(resolved);
  if (error || below.empty() || *below.begin() == "..") return false;
  const auto has = [&](const char* name) { return fs::is_directory(resolved / name, error); };
  return has("meshes") || has("materials") || has("textures") || has("media");
}

bool UrdfFiles::allow_if_package(const fs::path& folder, Sources& sources) {
  const fs::path mark = folder / "package.xml";
  sources.add(mark);
  if (!regular_file(mark) && !is_own_folder(folder)) return false;
  image_folders_.add(folder);
  return true;
}

Result<fs::path> UrdfFiles::find(std::string uri, Sources& sources) {
  const std::string name = quote(uri);
  if (uri.starts_with("file://$(find ")) uri.erase(0, 7);
  if (uri.starts_with("$(find ")) {
    const size_t end = uri.find(')');
    if (end == std::string::npos || uri.substr(end + 1, 1) != "/")
      return Error{name + " names no file of a package"};
    return find_in_package(uri.substr(7, end - 7), uri.substr(end + 2), name, sources);
  }
  for (const std::string scheme : {"package://", "model://"}) {
    if (!uri.starts_with(scheme)) continue;
    // Readers of ROS accept further slashes: package:///NAME/PATH, package://NAME//PATH.
    const std::string below = without_leading_slashes(uri.substr(scheme.size()));
    const size_t slash = below.find('/');
    if (slash == std::string::npos) return Error{name + " names no file of a package"};
    return find_in_package(below.substr(0, slash), without_leading_slashes(below.substr(slash)), name,
                           sources);
  }
  if (uri.starts_with("file://")) uri.erase(0, 7);
  if (begins_with_scheme(uri)) return Error{name + ": only package://, model://, file:// and paths are read"};
  const fs::path path = folder_ / uri;
  if (readable_) return path;
  std::error_code error;
  if (!fs::path(uri).is_absolute() || fs::exists(path, error)) return path;
  const fs::path end = fs::path(uri).relative_path();
  const fs::path found = find_by_end(end, 2);
  if (found.empty()) return path;
  note("file://", "there is no " + name + "; " + quote(found.string()) +
                      ", with the same end, is used instead, and so are such files of further paths");
  return found;
}

Result<fs::path> UrdfFiles::find_in_package(const std::string& package_name, const std::string& rest,
                                            const std::string& uri, Sources& sources) {
  if (package_name.empty() || package_name == "." || package_name == ".." || rest.empty())
    return Error{uri + " names no file of a package"};
  const Result<fs::path> folder = package(package_name, sources);
  if (folder) return *folder / rest;
  if (readable_) return folder.error();
  const fs::path end(rest);
  const fs::path found = find_by_end(end, static_cast<size_t>(std::distance(end.begin(), end.end())));
  if (found.empty()) return folder.error();
  note(package_name, folder.error().message + "; " + quote(found.string()) + " is used for " + uri +
                         " instead, and so are such files for its others");
  return found;
}

fs::path UrdfFiles::find_by_end(const fs::path& path, size_t fewest_parts) const {
  constexpr int kMaxLevels = 4;
  std::vector<fs::path> parts(path.begin(), path.end());
  if (std::find(parts.begin(), parts.end(), "..") != parts.end()) return {};
  for (size_t first = 0; first + std::max<size_t>(fewest_parts, 1) <= parts.size(); ++first) {
    fs::path end;
    for (size_t i = first; i < parts.size(); ++i) end /= parts[i];
    fs::path above = folder_;
    for (int level = 0; level < kMaxLevels && above != above.parent_path(); ++level) {
      if (regular_file(above / end)) return above / end;
      above = above.parent_path();
    }
  }
  return {};
}

void UrdfFiles::note(const std::string& kind, const std::string& sentence) {
  if (noted_.insert(kind).second) notes_.push_back(sentence);
}

}  // namespace fire3dv::convert
