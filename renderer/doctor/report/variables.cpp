#include "renderer/doctor/report/variables.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "base/words.h"

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
  return value.size() <= kMaxBytes && value.find("://") == std::string_view::npos &&
         std::all_of(value.begin(), value.end(), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) ||
                  std::string_view("_-.,:;*~+=!/@ ").find(c) != std::string_view::npos;
         });
}

// Folders and files by absolute or relative paths, and names of libraries.
bool is_path_list(std::string_view value) {
  constexpr size_t kMaxBytes = 1000;
  const auto is_path = [](std::string_view path) {
    return path.find('/') != std::string_view::npos || path.find(".so") != std::string_view::npos ||
           path.ends_with(".json");
  };
  if (value.size() > kMaxBytes || value.find("://") != std::string_view::npos) return false;
  const std::vector<std::string> paths = split(value, ":");
  return std::all_of(paths.begin(), paths.end(), is_path);
}

bool is_shown(const Variable& variable, std::string_view value) {
  return variable.value == Value::word ? is_word(value) : is_path_list(value);
}

// Parts of a value as findings quote them: a list's elements, cut and printable.
std::vector<std::string> quoted_parts(const std::string& value) {
  constexpr size_t kMinBytes = 3, kCutBytes[] = {120, 200, 1000};  // of quote(), and of names in the report
  std::vector<std::string> parts;
  const auto add = [&](const std::string& text) {
    if (text.size() >= kMinBytes) parts.push_back(text);
  };
  const auto add_all = [&](const std::string& text) {
    add(text);
    for (const std::string& part : split(text, ":'")) add(part);
  };
  add_all(value);
  add_all(terminal_text(value));
  add_all(printable_text(value, value.size()));
  for (const size_t bytes : kCutBytes) add_all(printable_text(value, bytes));
  return parts;
}

}  // namespace

std::string without_hidden_values(std::string text, const Facts& facts) {
  std::vector<std::string> hidden;
  for (const Variable& variable : kShown) {
    const std::string value = facts.variable(variable.name);
    if (is_shown(variable, value)) continue;
    const std::vector<std::string> parts = quoted_parts(value);
    hidden.insert(hidden.end(), parts.begin(), parts.end());
  }
  std::sort(hidden.begin(), hidden.end(),
            [](const std::string& a, const std::string& b) { return a.size() > b.size(); });
  constexpr std::string_view kInPlace = "(not shown)";
  for (const std::string& part : hidden) {
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + kInPlace.size()))
      text.replace(at, part.size(), kInPlace);
  }
  return text;
}

std::string variable_lines(const Facts& facts) {
  std::string lines;
  for (const Variable& variable : kShown) {
    const auto found = facts.environment.find(variable.name);
    if (found == facts.environment.end()) continue;
    const std::string& value = found->second;
    lines += std::string(variable.name) + "=" +
             (is_shown(variable, value) ? printable_text(value, value.size())
                                        : "(" + std::to_string(value.size()) + " bytes, not shown)") +
             "\n";
  }
  return lines;
}

}  // namespace fire3dv::doctor
