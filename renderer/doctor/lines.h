// Lines to type that several checks print. Texts of the environment and of files are quoted for a shell.
#pragma once

#include <string>
#include <string_view>

#include "base/words.h"
#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

inline constexpr const char* kUnsetDrivers = "unset VK_DRIVER_FILES VK_ICD_FILENAMES";
inline constexpr const char* kInstallDriver =
    "sudo apt-get install mesa-vulkan-drivers  # where fire3dv is from a wheel: install the file "
    "fire3dv_cpu-*.whl, too (docs/install.md)";
inline constexpr const char* kMoreFiles = "ulimit -n 1024";

inline std::string assignment(std::string_view name, std::string_view value) {
  return std::string(name) + "=" + shell_word(value);
}
inline std::string export_line(std::string_view name, std::string_view value) {
  return "export " + assignment(name, value);
}

// Switches implicit layers off by their own variables, which all loaders read.
inline std::string layers_off_line(const std::vector<LayerFacts>& layers) {
  std::string line = "export";
  for (const LayerFacts& layer : layers) line += " " + assignment(layer.variable, layer.value);
  return line;
}

}  // namespace fire3dv::doctor
