#include "renderer/doctor/driver_manifests.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "base/json/json_fault.h"
#include "base/words.h"

namespace fire3dv::doctor {
namespace {

using Environment = std::map<std::string, std::string>;
constexpr uint64_t kMaxManifestBytes = 1 << 20;
constexpr size_t kMaxManifests = 64;  // more are no installation

std::string value_of(const Environment& environment, const char* name) {
  const auto found = environment.find(name);
  return found == environment.end() ? "" : found->second;
}

std::vector<std::string> split_paths(const std::string& paths) {
  return split(paths, ":");
}

// A name that a shell's export takes: a manifest may hold any text.
bool is_variable_name(const std::string& name) {
  constexpr std::string_view kDigits = "0123456789",
                             kOther = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
  return !name.empty() && kDigits.find(name[0]) == std::string_view::npos &&
         name.find_first_not_of(std::string(kDigits) + std::string(kOther)) == std::string::npos;
}

std::filesystem::path under(const std::filesystem::path& root, const std::filesystem::path& path) {
  return path.is_absolute() ? root / path.relative_path() : path;
}

// Folders of the XDG specification in the loader's order.
std::vector<std::string> base_folders(const Environment& environment) {
  const auto either = [&](const char* name, const std::string& otherwise) {
    const std::string value = value_of(environment, name);
    return value.empty() ? otherwise : value;
  };
  const std::string home = value_of(environment, "HOME");
  std::vector<std::string> folders;
  const auto add = [&](const std::string& paths) {
    for (const std::string& path : split_paths(paths)) folders.push_back(path);
  };
  add(either("XDG_CONFIG_HOME", home.empty() ? "" : home + "/.config"));
  add(either("XDG_CONFIG_DIRS", "/etc/xdg"));
  add("/usr/local/etc:/etc");
  add(either("XDG_DATA_HOME", home.empty() ? "" : home + "/.local/share"));
  add(either("XDG_DATA_DIRS", "/usr/local/share:/usr/share"));
  return folders;
}

std::vector<std::filesystem::path> json_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (auto at = std::filesystem::directory_iterator(folder, error);
       !error && at != std::filesystem::directory_iterator() && files.size() < kMaxManifests;
       at.increment(error)) {
    if (at->path().extension() == ".json") files.push_back(at->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

Result<nlohmann::json> read_json(const std::filesystem::path& file) {
  const Result<FileBytes> bytes = read_file(file, kMaxManifestBytes);
  std::error_code ignored;
  if (!bytes)
    return Error{std::filesystem::exists(file, ignored) ? "it cannot be read" : "it does not exist"};
  // Copies of deep values would overflow the stack.
  constexpr int kMaxDepth = 32;
  const auto refuse_depth = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > kMaxDepth)
      throw std::length_error("it is nested deeper than " + std::to_string(kMaxDepth) + " levels");
    return true;
  };
  try {
    const auto* text = reinterpret_cast<const char*>(bytes->data.get());
    return nlohmann::json::parse(text, text + bytes->size, refuse_depth);
  } catch (const std::length_error& fault) {
    return Error{fault.what()};
  } catch (const nlohmann::json::exception& fault) {
    return Error{"it is no JSON: " + json_fault(fault.what())};
  }
}

ManifestFacts read_manifest(const std::string& file, const std::string& variable,
                            const std::filesystem::path& root) {
  ManifestFacts manifest;
  manifest.file = file;
  manifest.variable = variable;
  const Result<nlohmann::json> json = read_json(under(root, file));
  if (!json) {
    manifest.fault = json.error().message;
    return manifest;
  }
  const nlohmann::json* icd = json->is_object() && json->contains("ICD") ? &(*json)["ICD"] : nullptr;
  if (!icd || !icd->is_object() || !icd->contains("library_path") || !(*icd)["library_path"].is_string()) {
    manifest.fault = "it has no ICD.library_path";
    return manifest;
  }
  manifest.library = (*icd)["library_path"].get<std::string>();
  if (manifest.library.empty() || manifest.library.find('\0') != std::string::npos)
    manifest.fault = "its ICD.library_path is " + std::string(manifest.library.empty() ? "empty" : "no path");
  return manifest;
}

// The filter variable that hides a manifest: filters see the names of files. A selected driver is not
// disabled.
std::string hiding_variable(const Environment& environment, const std::string& file) {
  const std::string name = std::filesystem::path(file).filename().string();
  const std::string selected = value_of(environment, "VK_LOADER_DRIVERS_SELECT");
  if (!selected.empty()) return matches_filter(selected, name) ? "" : "VK_LOADER_DRIVERS_SELECT";
  return matches_filter(value_of(environment, "VK_LOADER_DRIVERS_DISABLE"), name)
             ? "VK_LOADER_DRIVERS_DISABLE"
             : "";
}

// The variable and the value that a member such as disable_environment names; nothing: none.
std::optional<std::pair<std::string, std::string>> variable_of(const nlohmann::json& layer,
                                                               const char* member) {
  if (!layer.contains(member) || !layer[member].is_object() || layer[member].empty()) return std::nullopt;
  const auto first = layer[member].begin();
  if (!is_variable_name(first.key())) return std::nullopt;
  return std::pair(first.key(), first->is_string() ? first->get<std::string>() : "");
}

// As the loader decides it.
bool is_active(const nlohmann::json& layer, const std::string& name, const Environment& environment,
               const LoaderFacts& loader) {
  const auto disabling = variable_of(layer, "disable_environment");
  if (!disabling || environment.contains(disabling->first)) return false;  // without one a layer is skipped
  const auto enabling = variable_of(layer, "enable_environment");
  const auto value = enabling ? environment.find(enabling->first) : environment.end();
  const bool enabled = !enabling || (value != environment.end() && value->second == enabling->second);
  if (!loader.reads(kReadsFilters)) return enabled;
  if (matches_filter(value_of(environment, "VK_LOADER_LAYERS_ENABLE"), name)) return true;
  const std::string disabled = value_of(environment, "VK_LOADER_LAYERS_DISABLE");
  const bool is_disabled = matches_filter(disabled, name) || matches_filter(disabled, "~implicit~") ||
                           matches_filter(disabled, "~all~");
  const bool is_allowed =
      loader.reads(kReadsAllow) && matches_filter(value_of(environment, "VK_LOADER_LAYERS_ALLOW"), name);
  return enabled && (!is_disabled || is_allowed);
}

}  // namespace

std::vector<ManifestFacts> find_driver_manifests(const Environment& environment, const LoaderFacts& loader,
                                                 const std::filesystem::path& root) {
  const bool reads_driver_files = loader.reads(kReadsDriverFiles);
  std::vector<std::pair<std::string, std::string>> files;  // and the variable that names each
  const auto add = [&](const std::string& path, const std::string& variable) {
    std::error_code ignored;
    if (std::filesystem::is_directory(under(root, path), ignored)) {
      for (const auto& file : json_files(under(root, path)))
        files.emplace_back((std::filesystem::path(path) / file.filename()).string(), variable);
    } else {
      files.emplace_back(path, variable);
    }
  };
  std::string replacing;
  for (const char* name : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) {
    const bool is_read = reads_driver_files || std::string_view(name) == "VK_ICD_FILENAMES";
    if (is_read && replacing.empty() && !value_of(environment, name).empty()) replacing = name;
  }
  if (!replacing.empty()) {
    for (const std::string& path : split_paths(value_of(environment, replacing.c_str())))
      add(path, replacing);
  } else {
    const std::string added = reads_driver_files ? value_of(environment, "VK_ADD_DRIVER_FILES") : "";
    for (const std::string& path : split_paths(added)) add(path, "VK_ADD_DRIVER_FILES");
    for (const std::string& folder : base_folders(environment)) {
      const std::string path = folder + "/vulkan/icd.d";
      std::error_code ignored;
      if (std::filesystem::is_directory(under(root, path), ignored)) add(path, "");
    }
  }
  std::vector<ManifestFacts> manifests;
  std::set<std::string> seen;
  for (const auto& [file, variable] : files) {
    if (manifests.size() < kMaxManifests && seen.insert(file).second)
      manifests.push_back(read_manifest(file, variable, root));
  }
  for (ManifestFacts& manifest : manifests) {
    if (loader.reads(kReadsFilters)) manifest.hidden_by = hiding_variable(environment, manifest.file);
  }
  return manifests;
}

std::vector<LayerFacts> find_implicit_layers(const Environment& environment, const LoaderFacts& loader,
                                             const std::filesystem::path& root) {
  std::vector<std::string> paths;
  for (const std::string& folder : base_folders(environment))
    paths.push_back(folder + "/vulkan/implicit_layer.d");
  if (loader.reads(kReadsLayerPaths)) {
    const std::vector<std::string> replacing = split_paths(value_of(environment, "VK_IMPLICIT_LAYER_PATH"));
    const std::vector<std::string> added = split_paths(value_of(environment, "VK_ADD_IMPLICIT_LAYER_PATH"));
    if (!replacing.empty()) paths = replacing;
    if (replacing.empty()) paths.insert(paths.begin(), added.begin(), added.end());
  }
  std::vector<LayerFacts> layers;
  std::set<std::string> seen;
  const auto read = [&](const std::string& file) {
    const Result<nlohmann::json> json = read_json(under(root, file));
    if (!json || !json->is_object()) return;
    std::vector<const nlohmann::json*> found;
    if (json->contains("layer")) found.push_back(&(*json)["layer"]);
    if (json->contains("layers") && (*json)["layers"].is_array()) {
      for (const nlohmann::json& layer : (*json)["layers"]) found.push_back(&layer);
    }
    for (const nlohmann::json* const layer : found) {
      if (!layer->is_object() || !layer->contains("name") || !(*layer)["name"].is_string()) continue;
      const std::string name = (*layer)["name"].get<std::string>();
      if (!is_active(*layer, name, environment, loader) || !seen.insert(name).second) continue;
      const auto disabling = *variable_of(*layer, "disable_environment");
      layers.push_back({name, file, disabling.first, disabling.second.empty() ? "1" : disabling.second, {}});
    }
  };
  for (const std::string& path : paths) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(under(root, path), ignored)) read(path);
    for (const auto& file : json_files(under(root, path)))
      read((std::filesystem::path(path) / file.filename()).string());
  }
  return layers;
}

std::string library_to_load(const ManifestFacts& manifest) {
  const std::filesystem::path library = manifest.library;
  if (manifest.library.find('/') == std::string::npos || library.is_absolute()) return manifest.library;
  return (std::filesystem::path(manifest.file).parent_path() / library).string();
}

}  // namespace fire3dv::doctor
