#include "renderer/app/options/config_file.h"

#include <algorithm>
#include <cstdint>
#include <system_error>

#include "base/files.h"
#include "base/words.h"

namespace fire3dv::app {
namespace {

constexpr uint64_t kMaxConfigBytes = 256 << 10;
constexpr size_t kMaxConfigLines = 100;  // each may cause a parse of all
constexpr std::string_view kBlank = " \t\r";

std::string with_home(std::string_view value, const std::string& home) {
  if (home.empty() || !value.starts_with("~/")) return std::string(value);
  return home + std::string(value.substr(1));
}

}  // namespace

Result<std::vector<ConfigLine>> parse_config(std::string_view text, const std::string& home) {
  std::vector<ConfigLine> lines;
  for (size_t number = 1; !text.empty(); ++number) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line.front() == '#') continue;
    if (line.find('\0') != std::string_view::npos)
      return Error{std::to_string(number) + ": a zero byte; the file must be text"};
    if (line.starts_with("--")) line.remove_prefix(2);
    const size_t name_end = std::min(line.find_first_of(" \t="), line.size());
    ConfigLine parsed{number, std::string(line.substr(0, name_end)), std::nullopt};
    if (parsed.name.empty() || parsed.name.front() == '-')
      return Error{std::to_string(number) +
                   ": no option's name; write \"option = value\", such as size = 1280x720"};
    std::string_view rest = trimmed(line.substr(name_end));
    const bool is_assigned = rest.starts_with('=');
    if (is_assigned) rest = trimmed(rest.substr(1));
    if (is_assigned || !rest.empty()) parsed.value = with_home(rest, home);
    if (lines.size() == kMaxConfigLines)
      return Error{std::to_string(number) + ": more than " + std::to_string(kMaxConfigLines) + " options"};
    lines.push_back(std::move(parsed));
  }
  return lines;
}

ConfigPath config_path(const std::string& option,
                       const std::function<const char*(const char*)>& environment) {
  const auto value_of = [&](const char* name) {
    const char* const value = environment(name);
    return std::string(value ? value : "");
  };
  const std::string variable = value_of("FIRE3DV_CONFIG");
  const std::string& chosen = option.empty() ? variable : option;
  if (chosen == "none") return {};
  if (!chosen.empty()) return {chosen, true};
  // The XDG specification requires that relative paths are ignored.
  if (const std::string config = value_of("XDG_CONFIG_HOME"); config.starts_with('/'))
    return {std::filesystem::path(config) / "fire3dv" / "config", false};
  if (const std::string home = value_of("HOME"); home.starts_with('/'))
    return {std::filesystem::path(home) / ".config" / "fire3dv" / "config", false};
  return {};
}

Result<std::vector<ConfigLine>> read_config(const ConfigPath& path, const std::string& home) {
  std::error_code error;
  if (path.file.empty() || (!path.must_exist && !std::filesystem::exists(path.file, error)))
    return std::vector<ConfigLine>();
  const Result<std::vector<uint8_t>> bytes = read_whole_file(path.file, kMaxConfigBytes);
  if (!bytes) return bytes.error();
  Result<std::vector<ConfigLine>> lines =
      parse_config({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, home);
  if (!lines) return Error{path.file.string() + ":" + lines.error().message};
  return lines;
}

}  // namespace fire3dv::app
