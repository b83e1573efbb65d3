// Facts of the system without Vulkan: files below /proc, /sys and /dev, limits, environment.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

// All variables of this process.
std::map<std::string, std::string> environment_variables();

// Fills the facts of files, folders, display and limits, of environment and cache_folder of `facts`. root:
// folder that stands for "/", for tests.
void gather_system_facts(Facts& facts, const std::filesystem::path& root = "/");

}  // namespace fire3dv::doctor
