#include "renderer/doctor/report/variables.h"

#include <algorithm>
#include <cctype>
#include <string_view>

#include "base/text.h"

namespace fire3dv::doctor {
namespace {

enum class Value {
  word,   // letters, digits, and signs of lists
  paths,  // separated by colons
};
struct Variable {
  const char* name;
  Value value;
};
constexpr Variable kShown[] = {
    {"CUDA_DEVICE_ORDER", Value::word},
    {"CUDA_VISIBLE_DEVICES", Value::word},
    {"DISPLAY", Value::word},
    {"DRI_PRIME", Value::word},
    {"FIRE3DV_DEVICE_MASK", Value::word},
    {"GALLIUM_DRIVER", Value::word},
    {"HOME", Value::paths},
    {"LANG", Value::word},
    {"LC_ALL", Value::word},
    {"LD_LIBRARY_PATH", Value::paths},
    {"LD_PRELOAD", Value::paths},
    {"LIBGL_ALWAYS_SOFTWARE", Value::word},
    {"LP_NATIVE_VECTOR_WIDTH", Value::word},
    {"LP_NUM_THREADS", Value::word},
    {"MESA_LOADER_DRIVER_OVERRIDE", Value::word},
    {"MESA_SHADER_CACHE_DIR", Value::paths},
    {"MESA_SHADER_CACHE_DISABLE", Value::word},
    {"MESA_VK_DEVICE_SELECT", Value::word},
    {"NODEVICE_SELECT", Value::word},
    {"NVIDIA_DRIVER_CAPABILITIES", Value::word},
    {"NVIDIA_VISIBLE_DEVICES", Value::word},
    {"RADV_FORCE_FAMILY", Value::word},
    {"TMPDIR", Value::paths},
    {"VK_ADD_DRIVER_FILES", Value::paths},
    {"VK_ADD_IMPLICIT_LAYER_PATH", Value::paths},
    {"VK_ADD_LAYER_PATH", Value::paths},
    {"VK_DRIVER_FILES", Value::paths},
    {"VK_ICD_FILENAMES", Value::paths},
    {"VK_IMPLICIT_LAYER_PATH", Value::paths},
    {"VK_INSTANCE_LAYERS", Value::word},
    {"VK_LAYER_PATH", Value::paths},
    {"VK_LOADER_DEBUG", Value::word},
    {"VK_LOADER_DISABLE_SELECT", Value::word},
    {"VK_LOADER_DRIVERS_DISABLE", Value::word},
    {"VK_LOADER_DRIVERS_SELECT", Value::word},
    {"VK_LOADER_LAYERS_ALLOW", Value::word},
    {"VK_LOADER_LAYERS_DISABLE", Value::word},
    {"VK_LOADER_LAYERS_ENABLE", Value::word},
    {"WAYLAND_DISPLAY", Value::word},
    {"XDG_CACHE_HOME", Value::paths},
    {"XDG_CONFIG_DIRS", Value::paths},
    {"XDG_CONFIG_HOME", Value::paths},
    {"XDG_DATA_DIRS", Value::paths},
    {"XDG_DATA_HOME", Value::paths},
    {"XDG_RUNTIME_DIR", Value::paths},
    {"XDG_SESSION_TYPE", Value::word},
    {"__EGL_VENDOR_LIBRARY_FILENAMES", Value::paths},
    {"__GLX_VENDOR_LIBRARY_NAME", Value::word},
    {"__NV_PRIME_RENDER_OFFLOAD", Value::word},
};

bool is_word(std::string_view value) {
  constexpr size_t kMaxBytes = 300;
  return value.size() <= kMaxBytes && std::all_of(value.begin(), value.end(), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) ||
                  std::string_view("_-.,:;*~+=!/@ ").find(c) != std::string_view::npos;
         });
}

// Folders and files by absolute or relative paths, and names of libraries.
bool is_path_list(std::string_view value) {
  constexpr size_t kMaxBytes = 1000;
  const auto is_path = [](std::string_view path) {
    return path.empty() || path.find('/') != std::string_view::npos ||
           path.find(".so") != std::string_view::npos || path.ends_with(".json");
  };
  if (value.size() > kMaxBytes || value.find("://") != std::string_view::npos) return false;
  for (size_t begin = 0; begin <= value.size();) {
    const size_t end = std::min(value.find(':', begin), value.size());
    if (!is_path(value.substr(begin, end - begin))) return false;
    begin = end + 1;
  }
  return true;
}

}  // namespace

std::string variable_lines(const Facts& facts) {
  std::string lines;
  for (const Variable& variable : kShown) {
    const auto found = facts.environment.find(variable.name);
    if (found == facts.environment.end()) continue;
    const std::string& value = found->second;
    const bool is_shown = variable.value == Value::word ? is_word(value) : is_path_list(value);
    lines += std::string(variable.name) + "=" +
             (is_shown ? terminal_text(value) : "(" + std::to_string(value.size()) + " bytes, not shown)") +
             "\n";
  }
  return lines;
}

}  // namespace fire3dv::doctor
