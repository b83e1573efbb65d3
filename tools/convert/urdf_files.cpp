#include "tools/convert/urdf_files.h"

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

UrdfFiles::UrdfFiles(const fs::path& urdf, const std::vector<fs::path>& package_folders) {
  std::error_code error;
  const fs::path file = fs::canonical(urdf, error);
  folder_ = error ? fs::absolute(urdf).parent_path() : file.parent_path();
  for (const fs::path& folder : package_folders) package_folders_.push_back(fs::absolute(folder));
}

Result<fs::path> UrdfFiles::resolve(const std::string& uri, std::vector<fs::path>& missing) const {
  const std::string name = scene::quote(uri);
  if (uri.empty()) return Error{"it names no file"};
  if (uri.find('\0') != std::string::npos) return Error{name + " holds a zero byte"};
  for (const std::string scheme : {"package://", "model://"}) {
    if (!uri.starts_with(scheme)) continue;
    const std::string below = uri.substr(scheme.size());
    const size_t slash = below.find('/');
    const std::string package = below.substr(0, slash);
    if (package.empty() || package == "." || package == ".." || slash == std::string::npos)
      return Error{name + " names no file of a package"};
    return in_package(package, below.substr(slash + 1), missing);
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

Result<fs::path> UrdfFiles::in_package(const std::string& name, const std::string& rest,
                                       std::vector<fs::path>& missing) const {
  for (const fs::path& folder : package_folders_) {
    if (is_folder(folder / name)) return folder / name / rest;
    if (folder.filename() == name || folder.parent_path().filename() == name) return folder / rest;
    missing.push_back(folder / name);
  }
  for (fs::path above = folder_;; above = above.parent_path()) {
    if (above.filename() == name) return above / rest;  // the URDF lies in its package
    if (is_folder(above / name)) return above / name / rest;
    missing.push_back(above / name);
    if (above == above.parent_path()) break;
  }
  return Error{"the package " + scene::quote(name) +
               " is not found: name the folder that holds it with --package-path"};
}

}  // namespace fire3dv::convert
