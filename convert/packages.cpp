#include "convert/packages.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/words.h"
#include "convert/description_files.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;
constexpr int kMaxDepth = 5;
constexpr size_t kMaxFolders = 20'000;         // visited by all searches together
constexpr size_t kMaxRecordedFolders = 2'000;  // as sources, whose change starts a new conversion
constexpr uint64_t kMaxManifestBytes = 1 << 20;

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

bool is_there(const fs::path& folder, Sources& sources) {
  if (is_folder(folder)) return true;
  sources.add(folder);  // may appear later
  return false;
}

// Absolute folders of a variable such as PATH.
std::vector<fs::path> folders_of_variable(const char* variable) {
  std::vector<fs::path> folders;
  const char* value = std::getenv(variable);
  std::string_view rest = value ? value : "";
  while (!rest.empty()) {
    const size_t colon = std::min(rest.find(':'), rest.size());
    if (rest.starts_with('/')) folders.emplace_back(rest.substr(0, colon));
    rest.remove_prefix(std::min(colon + 1, rest.size()));
  }
  return folders;
}

// Subfolders in the order of their names, without hidden ones.
std::vector<fs::path> subfolders_of(const fs::path& folder) {
  std::vector<fs::path> subfolders;
  std::error_code error;
  for (fs::directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error), end;
       !error && entry != end && subfolders.size() < kMaxFolders; entry.increment(error)) {
    if (!entry->path().filename().native().starts_with('.') && is_folder(entry->path()))
      subfolders.push_back(entry->path());
  }
  std::sort(subfolders.begin(), subfolders.end());
  return subfolders;
}

bool is_ignored(const fs::path& folder) {
  std::error_code error;
  for (const char* mark : {"CATKIN_IGNORE", "COLCON_IGNORE", "AMENT_IGNORE"})
    if (fs::exists(folder / mark, error)) return true;
  return false;
}

}  // namespace

std::string package_name(const fs::path& folder, Sources& sources) {
  const fs::path manifest = folder / "package.xml";
  sources.add(manifest);
  const Result<fs::path> file = regular_file(manifest);
  if (!file) return {};
  const Result<FileBytes> bytes = read_file(*file, kMaxManifestBytes);
  if (!bytes) return {};
  std::string text(reinterpret_cast<const char*>(bytes->data.get()), bytes->size);
  for (size_t at = text.find("<!--"); at != std::string::npos; at = text.find("<!--", at)) {
    const size_t end = text.find("-->", at);
    text.erase(at, end == std::string::npos ? end : end + 3 - at);
  }
  const size_t begin = text.find("<name>");
  const size_t end = text.find("</name>", begin);
  if (begin == std::string::npos || end == std::string::npos) return {};
  return std::string(trimmed(std::string_view(text).substr(begin + 6, end - begin - 6)));
}

std::vector<fs::path> installed_package_folders() {
  std::vector<fs::path> folders = folders_of_variable("ROS_PACKAGE_PATH");
  for (fs::path& prefix : folders_of_variable("AMENT_PREFIX_PATH")) folders.push_back(std::move(prefix));
  return folders;
}

bool ReadableFolders::hold(const fs::path& path) const {
  if (std::find(path.begin(), path.end(), "..") != path.end()) return false;
  const fs::path normal = path.lexically_normal();
  return std::any_of(folders_.begin(), folders_.end(), [&](const fs::path& folder) {
    const fs::path below = normal.lexically_relative(fs::absolute(folder).lexically_normal());
    return !below.empty() && *below.begin() != "..";
  });
}

Packages::Packages(const fs::path& description_folder, const std::vector<fs::path>& named)
    : folder_(description_folder),
      ros_folders_(folders_of_variable("ROS_PACKAGE_PATH")),
      ament_prefixes_(folders_of_variable("AMENT_PREFIX_PATH")) {
  for (const fs::path& folder : named) named_.push_back(fs::absolute(folder));
}

Result<fs::path> Packages::find(const std::string& name, Sources& sources) {
  if (std::optional<fs::path> found = find_in(named_, name, sources)) return *found;
  if (std::optional<fs::path> found = find_above(name, sources)) return *found;
  if (std::optional<fs::path> found = find_in(ros_folders_, name, sources)) return *found;
  for (const fs::path& prefix : ament_prefixes_)
    if (is_there(prefix / "share" / name, sources)) return prefix / "share" / name;
  return Error{"the package " + quote(name) +
               " is not found: name the folder that holds it with --package-path"};
}

std::optional<fs::path> Packages::own_package(Sources& sources) const {
  for (fs::path above = folder_; above != above.parent_path(); above = above.parent_path()) {
    sources.add(above / "package.xml");
    if (regular_file(above / "package.xml")) return above;
  }
  return std::nullopt;
}

std::optional<fs::path> Packages::find_in(const std::vector<fs::path>& folders, const std::string& name,
                                          Sources& sources) {
  for (const fs::path& folder : folders) {
    if (is_there(folder / name, sources)) return folder / name;
    // parent_path(): the folder's name ends with '/'
    if (folder.filename() == name || (!folder.has_filename() && folder.parent_path().filename() == name))
      return folder;
  }
  for (const fs::path& folder : folders) {
    const Index& index = index_of(folder, kMaxDepth, sources);
    if (const auto known = index.find(name); known != index.end()) return known->second;
  }
  return std::nullopt;
}

std::optional<fs::path> Packages::find_above(const std::string& name, Sources& sources) {
  if (folder_.empty()) return std::nullopt;
  const std::optional<fs::path> own = own_package(sources);
  if (own && package_name(*own, sources) == name) return own;
  for (fs::path above = folder_;; above = above.parent_path()) {
    if (above.filename() == name) return above;
    if (is_there(above / name, sources)) return above / name;
    if (above == above.parent_path()) break;
  }
  if (!own) return std::nullopt;
  const Index& beside = index_of(own->parent_path(), 1, sources);
  const auto known = beside.find(name);
  return known == beside.end() ? std::nullopt : std::optional(known->second);
}

const Packages::Index& Packages::index_of(const fs::path& root, int depth, Sources& sources) {
  const auto [known, is_new] = indices_.try_emplace(root);
  Index& index = known->second;
  if (!is_new) return index;
  std::set<fs::path> seen;  // symbolic links may form a cycle
  std::vector<std::pair<fs::path, int>> left{{root, 0}};
  for (size_t i = 0; i < left.size() && visited_ < kMaxFolders; ++i) {
    const auto [folder, level] = left[i];
    std::error_code error;
    const fs::path resolved = fs::canonical(folder, error);
    if (error || !seen.insert(resolved).second || is_ignored(folder)) continue;
    if (++visited_ <= kMaxRecordedFolders) sources.add(folder);
    if (regular_file(folder / "package.xml")) {
      if (const std::string name = package_name(folder, sources); !name.empty())
        index.try_emplace(name, folder);
      if (folder != root) continue;
    }
    if (level < depth)
      for (fs::path& subfolder : subfolders_of(folder)) left.emplace_back(std::move(subfolder), level + 1);
  }
  return index;
}

}  // namespace fire3dv::convert
