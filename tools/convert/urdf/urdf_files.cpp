#include "tools/convert/urdf/urdf_files.h"

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

bool begins_with_scheme(const std::string& uri) {
  const size_t mark = uri.find("://");
  return mark != std::string::npos && mark < uri.find('/');
}

}  // namespace

UrdfFiles::UrdfFiles(const fs::path& urdf, const std::vector<fs::path>& package_folders, Sources& sources) {
  std::error_code error;
  const fs::path file = fs::canonical(urdf, error);
  folder_ = error ? fs::absolute(urdf).parent_path() : file.parent_path();
  image_folders_.add(folder_);
  image_folders_.add(urdf.parent_path());  // folder of the symbolic link
  for (const fs::path& folder : package_folders) {
    package_folders_.push_back(fs::absolute(folder));
    image_folders_.add(folder);
  }
  for (fs::path above = folder_; above != above.parent_path(); above = above.parent_path())
    if (allow_if_package(above, sources)) break;
}

Result<fs::path> UrdfFiles::resolve(const std::string& uri, Sources& sources) {
  Result<fs::path> path = find(uri, sources);
  if (path) sources.add(*path);
  return path;
}

bool UrdfFiles::allow_if_package(const fs::path& folder, Sources& sources) {
  const fs::path mark = folder / "package.xml";
  sources.add(mark);
  if (!regular_file(mark)) return false;
  image_folders_.add(folder);
  return true;
}

Result<fs::path> UrdfFiles::find(const std::string& uri, Sources& sources) {
  const std::string name = quote(uri);
  if (uri.empty()) return Error{"it names no file"};
  if (uri.find('\0') != std::string::npos) return Error{name + " holds a zero byte"};
  for (const std::string scheme : {"package://", "model://"}) {
    if (!uri.starts_with(scheme)) continue;
    const std::string below = uri.substr(scheme.size());
    const size_t slash = below.find('/');
    const std::string package = below.substr(0, slash);
    if (package.empty() || package == "." || package == ".." || slash == std::string::npos)
      return Error{name + " names no file of a package"};
    const Result<fs::path> folder = package_folder(package, sources);
    if (!folder) return folder.error();
    allow_if_package(*folder, sources);
    return *folder / below.substr(slash + 1);
  }
  if (uri.starts_with("file://")) {
    const std::string path = uri.substr(7);
    if (!path.starts_with('/'))
      return Error{name + " is of another machine, or not absolute: file:///PATH is read"};
    return fs::path(path);
  }
  if (begins_with_scheme(uri)) return Error{name + ": only package://, file:// and paths are read"};
  return folder_ / uri;
}

Result<fs::path> UrdfFiles::package_folder(const std::string& name, Sources& sources) {
  const auto is_there = [&](const fs::path& folder) {
    if (is_folder(folder)) return true;
    sources.add(folder);  // may appear later
    return false;
  };
  for (const fs::path& folder : package_folders_) {
    if (is_there(folder / name)) return folder / name;
    if (folder.filename() == name || folder.parent_path().filename() == name) return folder;
  }
  for (fs::path above = folder_;; above = above.parent_path()) {
    if (above.filename() == name) return above;  // the URDF lies inside its package
    if (is_there(above / name)) return above / name;
    if (above == above.parent_path()) break;
  }
  return Error{"the package " + quote(name) +
               " is not found: name the folder that holds it with --package-path"};
}

}  // namespace fire3dv::convert
