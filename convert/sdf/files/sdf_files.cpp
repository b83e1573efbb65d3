#include "convert/sdf/files/sdf_files.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "base/text.h"
#include "convert/sdf/files/sdf_version.h"
#include "convert/urdf_files.h"
#include "convert/xml_error.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxUriBytes = 4096;  // longer ones are no paths of a system
constexpr size_t kMaxMissing = 10'000;

constexpr const char* kVariables[] = {"GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH",
                                      "GAZEBO_MODEL_PATH", "GAZEBO_RESOURCE_PATH"};

fs::path folder_of(const fs::path& file) {
  std::error_code error;
  const fs::path resolved = fs::canonical(file, error);
  return error ? fs::absolute(file).parent_path() : resolved.parent_path();
}

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::vector<fs::path> absolute_folders(std::string_view list) {
  std::vector<fs::path> folders;
  while (!list.empty()) {
    const size_t colon = std::min(list.find(':'), list.size());
    if (list.starts_with('/')) folders.emplace_back(list.substr(0, colon));
    list.remove_prefix(std::min(colon + 1, list.size()));
  }
  return folders;
}

bool leaves_its_folder(const fs::path& below) {
  return below.empty() || below.is_absolute() || std::find(below.begin(), below.end(), "..") != below.end();
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  constexpr size_t kMaxEntries = 10'000;
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end;
       !error && entry != end && entries.size() < kMaxEntries; entry.increment(error))
    entries.push_back(entry->path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

// Newest version of a cached model: folders are named by numbers.
std::optional<fs::path> newest_version(const fs::path& model) {
  std::optional<fs::path> newest;
  unsigned long best = 0;
  std::error_code error;
  for (fs::directory_iterator entry(model, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.empty() || name.size() > 9 || name.find_first_not_of("0123456789") != std::string::npos)
      continue;
    const unsigned long version = std::stoul(name);
    if (newest && version <= best) continue;
    newest = entry->path();
    best = version;
  }
  return newest;
}

}  // namespace

SdfFiles::SdfFiles(const fs::path& file, const std::vector<fs::path>& package_folders, Sources& sources)
    : folder_(folder_of(file)), packages_(folder_, package_folders), sources_(&sources) {
  image_folders_.add(folder_);
  image_folders_.add(file.parent_path());  // folder of the symbolic link
  add_folders(package_folders);
  allow_model_of(file);
}

SdfFiles::SdfFiles(const std::vector<fs::path>& package_folders, std::string folder_option,
                   const fs::path& file)
    : option_(std::move(folder_option)), packages_({}, package_folders) {
  add_folders(package_folders);
  std::vector<fs::path> readable = caches_;
  for (const Folder& folder : folders_) readable.push_back(folder.path);
  for (fs::path& folder : installed_package_folders()) readable.push_back(std::move(folder));
  if (!file.empty()) readable.push_back(folder_of(file));
  if (!file.empty()) image_folders_.add(folder_of(file));
  readable_.emplace(std::move(readable));
}

void SdfFiles::add_folders(const std::vector<fs::path>& package_folders) {
  for (const fs::path& folder : package_folders) folders_.push_back({fs::absolute(folder), option_});
  for (const char* name : kVariables)
    for (fs::path& folder : absolute_folders(variable(name))) folders_.push_back({std::move(folder), name});
  for (const Folder& folder : folders_) image_folders_.add(folder.path);
  for (const char* name : {"GZ_FUEL_CACHE_PATH", "IGN_FUEL_CACHE_PATH"})
    if (const std::string value = variable(name); value.starts_with('/')) caches_.emplace_back(value);
  if (const std::string home = variable("HOME"); home.starts_with('/'))
    for (const char* below : {".gz/fuel", ".ignition/fuel"}) caches_.push_back(fs::path(home) / below);
}

Result<fs::path> SdfFiles::resolve(const std::string& uri, const fs::path& from) {
  if (uri.empty()) return Error{"it names no file"};
  if (uri.size() > kMaxUriBytes)
    return Error{"a path of " + std::to_string(uri.size()) + " bytes is not searched"};
  if (uri.find('\0') != std::string::npos) return Error{quote(uri) + " holds a zero byte"};
  if (missing_ == kMaxMissing)
    return Error{quote(uri) + " is not searched: " + std::to_string(kMaxMissing) +
                 " files were not found before"};
  Result<fs::path> found = find(uri, from);
  if (const std::string decoded = percent_decoded(uri); !found && decoded != uri)
    if (Result<fs::path> second = find(decoded, from)) found = std::move(second);
  if (!found) ++missing_;
  if (found) allow_model_of(*found);
  return found;
}

Result<fs::path> SdfFiles::find(const std::string& uri, const fs::path& from) {
  for (const std::string_view scheme : {"model://", "package://"})
    if (uri.starts_with(scheme)) return find_in_models(uri.substr(scheme.size()), uri);
  if (uri.starts_with("https://") || uri.starts_with("http://")) return find_in_fuel_cache(uri);
  std::string path = uri;
  if (path.starts_with("file://")) path.erase(0, 7);
  if (const size_t mark = path.find("://"); mark != std::string::npos && mark < path.find('/'))
    return Error{quote(uri) + ": only model://, package://, file:// and paths are read"};
  if (fs::path(path).is_absolute()) {
    if (is_readable(path) && exists(path)) return fs::path(path);
    if (std::optional<fs::path> found = find_by_end(path)) return *std::move(found);
    if (!is_readable(path))
      return Error{quote(path) +
                   " lies outside the folders that a stranger may name files of, and its end "
                   "is not found in " +
                   searched()};
    return Error{"there is no " + quote(path) + ", and its end is not found in " + searched()};
  }
  if (!from.empty()) {
    const fs::path beside = folder_of(from) / path;
    if (is_readable(beside) && exists(beside)) return beside;
  }
  for (const Folder& folder : folders_)
    if (!leaves_its_folder(path) && exists(folder.path / path)) return folder.path / path;
  if (std::optional<fs::path> found = find_above(path)) return *std::move(found);
  // <uri>NAME</uri> of a model, and file://models/NAME below the folders of models.
  if (const Result<fs::path> model = find_in_models(path, uri)) return *model;
  if (const std::string_view models = "models/"; path.starts_with(models))
    if (const Result<fs::path> model = find_in_models(path.substr(models.size()), uri)) return *model;
  return Error{quote(uri) + " is " +
               (from.empty() ? "not found in " : "neither beside " + quote(from.string()) + " nor in ") +
               searched()};
}

// A path below a folder above the file, or below `models` in one: worlds/ beside models/ is Gazebo's usual
// layout.
std::optional<fs::path> SdfFiles::find_above(const fs::path& path) {
  constexpr int kMaxLevels = 4;
  if (folder_.empty() || leaves_its_folder(path)) return std::nullopt;
  fs::path above = folder_;
  for (int level = 0; level < kMaxLevels && above != above.parent_path();
       ++level, above = above.parent_path())
    for (const fs::path& folder : {above, above / "models"})
      if (exists(folder / path)) return folder / path;
  return std::nullopt;
}

// The longest end of at least two components that one of the folders holds.
std::optional<fs::path> SdfFiles::find_by_end(const fs::path& path) {
  constexpr size_t kMaxParts = 16, kMinParts = 2;
  std::vector<fs::path> parts;
  for (const fs::path& part : path.lexically_normal().relative_path()) parts.push_back(part);
  for (size_t count = std::min(parts.size(), kMaxParts); count >= kMinParts; --count) {
    fs::path end;
    for (size_t i = parts.size() - count; i < parts.size(); ++i) end /= parts[i];
    for (const Folder& folder : folders_)
      if (!leaves_its_folder(end) && exists(folder.path / end)) return folder.path / end;
  }
  return std::nullopt;
}

Result<fs::path> SdfFiles::find_in_models(const std::string& below, const std::string& uri) {
  const fs::path path = fs::path(below).lexically_normal();
  const std::string name = path.empty() ? std::string() : path.begin()->string();
  if (name.empty() || name == "." || leaves_its_folder(path)) return Error{quote(uri) + " names no model"};
  const fs::path rest = path.lexically_relative(name);
  for (const Folder& folder : folders_) {
    if (exists(folder.path / path)) return folder.path / path;
    // The folder may be the model itself.
    const fs::path last =
        folder.path.has_filename() ? folder.path.filename() : folder.path.parent_path().filename();
    if (last == name && exists(folder.path / rest)) return folder.path / rest;
  }
  if (std::optional<fs::path> found = find_above(path)) return *std::move(found);
  // Folders above the description, and packages by their package.xml.
  Sources unrecorded;
  if (const Result<fs::path> package = packages_.find(name, sources_ ? *sources_ : unrecorded);
      package && exists(*package / rest))
    return *package / rest;
  if (std::optional<fs::path> found = find_model_in_fuel_cache(name, rest)) return *std::move(found);
  return Error{quote(uri) + " is not found in " + searched()};
}

// A model that Gazebo has downloaded, whoever owns it.
std::optional<fs::path> SdfFiles::find_model_in_fuel_cache(const std::string& model, const fs::path& below) {
  for (const fs::path& cache : caches_) {
    for (const fs::path& server : entries_of(cache)) {
      for (const fs::path& owner : entries_of(server)) {
        const std::optional<fs::path> version = newest_version(owner / "models" / lower_case(model));
        if (!version || !exists(*version / below)) continue;
        image_folders_.add(*version);
        return *version / below;
      }
    }
  }
  return std::nullopt;
}

// URI: https://SERVER[/VERSION]/OWNER/models/NAME[/N][/files/PATH]; cache: SERVER/owner/models/name/N/PATH.
Result<fs::path> SdfFiles::find_in_fuel_cache(const std::string& uri) {
  std::vector<std::string> parts;
  const std::string rest = uri.substr(uri.find("://") + 3);
  for (const fs::path& part : fs::path(rest)) parts.push_back(part.string());
  std::string looked;
  for (const fs::path& cache : caches_) looked += (looked.empty() ? "" : ", ") + quote(cache.string());
  const Error missing{quote(uri) + " is not in the cache of Gazebo Fuel (" + looked +
                      "), and nothing is downloaded: fetch it with \"gz fuel download -u " + uri + "\""};
  const auto is_kind = [&](size_t i) {
    return parts.size() > i + 1 && (parts[i] == "models" || parts[i] == "worlds");
  };
  if (is_kind(2) && !is_kind(3)) parts.insert(parts.begin() + 1, "1.0");
  if (!is_kind(3) || leaves_its_folder(rest)) return missing;
  size_t next = 5;
  std::string version;
  if (next < parts.size() && !parts[next].empty() &&
      parts[next].find_first_not_of("0123456789") == std::string::npos)
    version = parts[next++];
  if (next < parts.size() && (parts[next] == "tip" || parts[next] == "files")) ++next;
  if (next < parts.size() && parts[next] == "files") ++next;
  fs::path below;
  for (; next < parts.size(); ++next) below /= parts[next];
  for (const fs::path& cache : caches_) {
    const fs::path model = cache / parts[0] / lower_case(parts[2]) / parts[3] / lower_case(parts[4]);
    if (sources_) sources_->add(model);
    const std::optional<fs::path> folder = version.empty() ? newest_version(model) : model / version;
    if (!folder || !exists(*folder / below)) continue;
    image_folders_.add(*folder);
    return *folder / below;
  }
  return missing;
}

bool SdfFiles::exists(const fs::path& path) {
  if (sources_) sources_->add(path);
  std::error_code error;
  return fs::exists(path, error);
}

void SdfFiles::allow_model_of(const fs::path& path) {
  constexpr int kMaxLevels = 9;  // the file, and eight folders above it
  std::error_code error;
  fs::path folder = fs::canonical(path, error);
  if (error) return;
  for (int level = 0; level < kMaxLevels && folder != folder.parent_path();
       ++level, folder = folder.parent_path())
    if (regular_file(folder / "model.config") || regular_file(folder / "package.xml"))
      return image_folders_.add(folder);
}

std::string SdfFiles::searched() const {
  std::string text;
  for (const Folder& folder : folders_)
    text += (text.empty() ? "" : ", ") + quote(folder.path.string()) + " (" + folder.origin + ")";
  if (!folder_.empty()) text += (text.empty() ? "" : ", ") + ("the folders above " + quote(folder_.string()));
  if (text.empty()) text = "a folder, as none is named";
  return text + ": set GZ_SIM_RESOURCE_PATH to the folder that holds it, or name that with " + option_;
}

std::string SdfFiles::outside_image_folders() const {
  return std::string("it lies outside the folders ") + (folder_.empty() ? "" : "of the SDF file, ") +
         "of models (by their model.config), of the search paths and of " + option_ + "; " +
         (folder_.empty() ? "" : "copy it next to the SDF file, or ") + "name its folder with " + option_;
}

Result<fs::path> sdf_of_model_folder(const fs::path& folder, unsigned newest, Sources& sources) {
  const fs::path config = folder / "model.config";
  sources.add(config);
  const Result<fs::path> file = regular_file(config);
  if (!file) return Error{quote(folder.string()) + " is not a model: it has no model.config"};
  const Result<std::string> text = read_text(*file);
  if (!text) return text.error();
  const std::string name = quote(config.string());
  if (const Result<std::string> root = xml_root(*text); !root)
    return Error{name + ": " + root.error().message};
  tinyxml2::XMLDocument document;
  if (document.Parse(text->c_str()) != tinyxml2::XML_SUCCESS) return Error{name + ", " + xml_error(document)};
  const tinyxml2::XMLElement* model = document.FirstChildElement("model");
  // Newest version that is read, else the oldest of the others.
  std::string best;
  long best_rank = 0;
  for (const tinyxml2::XMLElement* sdf = model ? model->FirstChildElement("sdf") : nullptr; sdf;
       sdf = sdf->NextSiblingElement("sdf")) {
    const char* path = sdf->GetText();
    const char* version_text = sdf->Attribute("version");
    if (!path) continue;
    const long minor = static_cast<long>(minor_sdf_version(version_text ? version_text : "").value_or(0));
    const long rank = minor <= static_cast<long>(newest) ? 1000 + minor : 1000 - minor;
    if (!best.empty() && rank <= best_rank) continue;
    best = path;
    best_rank = rank;
  }
  if (best.empty()) return Error{name + " names no <sdf> file"};
  if (leaves_its_folder(best)) return Error{name + ": " + quote(best) + " lies outside the model's folder"};
  sources.add(folder / best);
  if (const Result<fs::path> there = regular_file(folder / best); !there) return there.error();
  return folder / best;
}

}  // namespace fire3dv::convert
