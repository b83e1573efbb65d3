// Configuration file of the renderer: options in lines of their own, with the names and values of the command
// line. The command line takes precedence.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::app {

struct ConfigLine {
  size_t number = 0;  // in the file, from 1
  std::string name;   // without dashes
  std::optional<std::string> value;
  bool operator==(const ConfigLine&) const = default;
  // As a word of a command line.
  std::string argument() const { return "--" + name + (value ? "=" + *value : ""); }
};

// Lines are "option = value", "option value" or "option"; empty lines and lines that begin with # are left
// out. "~/" at the beginning of a value stands for home, if it is known. Fails for lines without a name.
Result<std::vector<ConfigLine>> parse_config(std::string_view text, const std::string& home);

// Place of the file without --config: FIRE3DV_CONFIG, else below XDG_CONFIG_HOME or ~/.config.
struct ConfigPath {
  std::filesystem::path file;  // empty: none
  bool must_exist = false;
};
// option: value of --config; empty: not given.
ConfigPath config_path(const std::string& option, const std::function<const char*(const char*)>& environment);

// The lines of the file; none if it does not exist and need not. The error names the file.
Result<std::vector<ConfigLine>> read_config(const ConfigPath& place, const std::string& home);

}  // namespace fire3dv::app
