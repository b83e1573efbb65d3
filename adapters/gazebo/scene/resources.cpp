#include "adapters/gazebo/scene/resources.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "protocol/base/text.h"

namespace fire3dv::gazebo {
namespace {

constexpr size_t kMaxPathBytes = 4096;  // longer ones are no paths of a system

namespace fs = std::filesystem;

std::vector<fs::path> folders_of(const char* variable) {
  std::vector<fs::path> folders;
  const char* value = std::getenv(variable);
  std::string_view rest = value ? value : "";
  while (!rest.empty()) {
    const size_t colon = std::min(rest.find(':'), rest.size());
    if (colon > 0) folders.emplace_back(rest.substr(0, colon));
    rest.remove_prefix(std::min(colon + 1, rest.size()));
  }
  return folders;
}

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

// Relative and without "..", so that it stays below a folder.
std::optional<fs::path> inner_path(std::string_view text) {
  const fs::path path = fs::path(text).lexically_normal().relative_path();
  if (path.empty() || *path.begin() == "..") return std::nullopt;
  return path;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The folder of the newest version of a model in a Fuel cache.
std::optional<fs::path> newest_version(const fs::path& model) {
  std::error_code error;
  std::optional<std::pair<int, fs::path>> newest;
  for (fs::directory_iterator entry(model, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    int number = 0;
    const auto [last, failure] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (failure != std::errc() || last != name.data() + name.size()) continue;
    if (!newest || number > newest->first) newest = {number, entry->path()};
  }
  if (!newest) return std::nullopt;
  return newest->second;
}

// SERVER/1.0/OWNER/models/NAME/VERSION/files/REST, or without 1.0 or VERSION, to a path below the cache.
std::optional<fs::path> in_fuel_cache(const fs::path& cache, std::string_view uri) {
  const std::optional<fs::path> inner = inner_path(uri.substr(uri.find("://") + 3));
  if (!inner) return std::nullopt;
  std::vector<std::string> parts;
  for (const fs::path& part : *inner) parts.push_back(part.string());
  if (parts.size() > 2 && parts[1] == "1.0") parts.erase(parts.begin() + 1);
  if (parts.size() < 6 || parts[2] != "models") return std::nullopt;
  const fs::path model = cache / lower(parts[0]) / lower(parts[1]) / "models" / lower(parts[3]);
  size_t rest = 4;
  std::optional<fs::path> version;
  if (parts[4] == "tip" || parts[4] == "files") {
    version = newest_version(model);
  } else {
    version = model / parts[4];
  }
  if (parts[rest] != "files") ++rest;
  if (!version || rest >= parts.size() || parts[rest] != "files") return std::nullopt;
  fs::path file = *version;
  for (size_t i = rest + 1; i < parts.size(); ++i) file /= parts[i];
  return file;
}

}  // namespace

Resources::Resources(std::vector<fs::path> folders) : folders_(std::move(folders)) {}

Resources Resources::from_environment(std::vector<fs::path> folders) {
  for (const char* variable : {"GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH"})
    for (fs::path& folder : folders_of(variable)) folders.push_back(std::move(folder));
  Resources resources(std::move(folders));
  for (const char* variable : {"GZ_FUEL_CACHE_PATH", "IGN_FUEL_CACHE_PATH"})
    for (fs::path& folder : folders_of(variable)) resources.fuel_caches_.push_back(std::move(folder));
  if (const char* home = std::getenv("HOME"); home && *home)
    for (const char* name : {".gz/fuel", ".ignition/fuel"})
      resources.fuel_caches_.push_back(fs::path(home) / name);
  return resources;
}

Result<fs::path> Resources::find(const std::string& uri) const {
  std::string tried;
  const auto exists = [&](const fs::path& path) {
    if (is_file(path)) return true;
    constexpr size_t kMaxText = 600;
    if (tried.size() < kMaxText) tried += (tried.empty() ? "" : ", ") + printable_text(path.string(), 200);
    return false;
  };
  const size_t scheme_end = uri.find("://");
  const std::string scheme = scheme_end == uri.npos ? "" : uri.substr(0, scheme_end);
  std::string rest = scheme_end == uri.npos ? uri : uri.substr(scheme_end + 3);
  if (scheme == "http" || scheme == "https") {
    for (const fs::path& cache : fuel_caches_) {
      const std::optional<fs::path> file = in_fuel_cache(cache, uri);
      if (file && exists(*file)) return *file;
    }
    return Error{quote(uri) + " is not in the Fuel cache" + (tried.empty() ? "" : " (tried " + tried + ")") +
                 ": nothing is downloaded here; Gazebo fills ~/.gz/fuel, or set GZ_FUEL_CACHE_PATH"};
  }
  if (scheme.empty() || scheme == "file") {
    if (fs::path(rest).is_absolute() && exists(rest)) return fs::path(rest);
  } else if (scheme != "model" && scheme != "package") {
    return Error{quote(uri) + " has an unknown scheme: model, package, file, http and https are known"};
  }
  if (rest.size() > kMaxPathBytes)
    return Error{"a path of " + std::to_string(rest.size()) + " bytes is not searched"};
  if (const std::optional<fs::path> inner = inner_path(rest)) {
    // A path of another machine is searched by its end.
    const bool is_absolute = fs::path(rest).is_absolute();
    for (const fs::path& folder : folders_) {
      fs::path end = *inner;
      while (true) {
        if (exists(folder / end)) return folder / end;
        // The folder may be the model itself.
        if (!is_absolute && folder.filename() == *end.begin() && exists(folder.parent_path() / end))
          return folder.parent_path() / end;
        if (!is_absolute) break;
        fs::path shorter;
        for (auto part = std::next(end.begin()); part != end.end(); ++part) shorter /= *part;
        if (shorter.empty() || std::next(shorter.begin()) == shorter.end()) break;  // two components at least
        end = shorter;
      }
    }
    if (scheme == "model" || scheme == "package") {
      const std::string model = lower(inner->begin()->string());
      fs::path file;
      for (auto part = std::next(inner->begin()); part != inner->end(); ++part) file /= *part;
      for (const fs::path& cache : fuel_caches_) {
        std::error_code error;
        for (fs::directory_iterator server(cache, error), end; !error && server != end;
             server.increment(error)) {
          std::error_code inner_error;
          for (fs::directory_iterator owner(server->path(), inner_error); !inner_error && owner != end;
               owner.increment(inner_error)) {
            const std::optional<fs::path> version = newest_version(owner->path() / "models" / model);
            if (version && exists(*version / file)) return *version / file;
          }
        }
      }
    }
  }
  return Error{quote(uri) + " is not found" + (tried.empty() ? "" : " (tried " + tried + ")") +
               ": name its folder with --resource-path or GZ_SIM_RESOURCE_PATH"};
}

convert::AllowedFolders Resources::image_folders(const fs::path& file) const {
  convert::AllowedFolders allowed;
  for (const fs::path& folder : folders_) allowed.add(folder);
  for (const fs::path& folder : fuel_caches_) allowed.add(folder);
  constexpr int kMaxLevels = 8;
  fs::path folder = file.parent_path();
  for (int level = 0; level < kMaxLevels && folder.has_relative_path();
       ++level, folder = folder.parent_path()) {
    if (!is_file(folder / "model.config")) continue;
    allowed.add(folder);
    break;
  }
  return allowed;
}

}  // namespace fire3dv::gazebo
