// Search for the manifests of Vulkan drivers and implicit layers, as the Vulkan loader does it on Linux.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

// root: folder in front of all folders of the system and of absolute paths, for tests; "/" otherwise. An
// unknown loader is a new one.
std::vector<ManifestFacts> find_driver_manifests(const std::map<std::string, std::string>& environment,
                                                 const LoaderFacts& loader = {},
                                                 const std::filesystem::path& root = "/");

// Implicit layers that the environment neither disables nor fails to enable.
std::vector<LayerFacts> find_implicit_layers(const std::map<std::string, std::string>& environment,
                                             const LoaderFacts& loader = {},
                                             const std::filesystem::path& root = "/");

// Name or path for dlopen(): a library_path with a folder is relative to its manifest.
std::string library_to_load(const ManifestFacts& manifest);

}  // namespace fire3dv::doctor
