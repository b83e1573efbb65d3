#include "adapters/ambf/launch.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

namespace fire3dv::ambf {
namespace {

namespace fs = std::filesystem;

// All long options of AMBF, which accepts any unambiguous prefix.
constexpr std::array kLongOptions{"help",
                                  "ndevs",
                                  "load_devices",
                                  "enableforces",
                                  "phx_frequency",
                                  "htx_frequency",
                                  "fixed_phx_timestep",
                                  "fixed_htx_timestep",
                                  "show_gui",
                                  "ns",
                                  "override_max_comm_freq",
                                  "override_min_comm_freq",
                                  "plugins",
                                  "launch_file",
                                  "load_multibody_files",
                                  "load_multibodies",
                                  "sim_speed_factor"};

bool names(const std::string& given, const std::string& option) {
  if (given == option) return true;
  size_t beginnings = 0;
  bool ours = false;
  for (const char* const known : kLongOptions) {
    const std::string text = known;
    if (text == given) return false;
    if (text.compare(0, given.size(), given) != 0) continue;
    ++beginnings;
    ours = ours || text == option;
  }
  return ours && beginnings == 1;
}

// Accepts --name V, --name=V, -s V and -sV.
std::optional<std::string> value_of(const std::vector<std::string>& arguments, const std::string& option,
                                    char letter) {
  for (size_t i = 1; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    const auto next = [&]() -> std::optional<std::string> {
      if (i + 1 < arguments.size()) return arguments[i + 1];
      return std::nullopt;
    };
    if (word.size() > 2 && word.compare(0, 2, "--") == 0) {
      const size_t equals = word.find('=');
      const std::string given = word.substr(2, equals == std::string::npos ? equals : equals - 2);
      if (!names(given, option)) continue;
      return equals == std::string::npos ? next() : word.substr(equals + 1);
    }
    if (letter != 0 && word.size() >= 2 && word[0] == '-' && word[1] == letter)
      return word.size() == 2 ? next() : word.substr(2);
  }
  return std::nullopt;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

// Returns a scalar, or a list joined by commas.
std::string text_of(const YAML::Node& node) {
  if (!node.IsSequence()) return node.as<std::string>();
  std::string text;
  for (const YAML::Node& item : node) text += (text.empty() ? "" : ",") + item.as<std::string>();
  return text;
}

// Returns model files in AMBF's order: files of -a, then launch file entries by index. Without either, entry
// 1. Unreadable indices are skipped, since AMBF exits on them before it loads the plugin.
std::vector<fs::path> loaded_models(const std::vector<std::string>& arguments, const YAML::Node& listed,
                                    const fs::path& folder) {
  std::vector<fs::path> models;
  const auto files = value_of(arguments, "load_multibody_files", 'a');
  auto indices = value_of(arguments, "load_multibodies", 'l');
  if (files) {
    for (const std::string& file : split(*files)) models.emplace_back(file);
  }
  if (!indices && models.empty()) indices = "1";
  std::string digits = indices.value_or("");
  digits.erase(std::remove(digits.begin(), digits.end(), ' '), digits.end());
  for (const std::string& number : split(digits)) {
    size_t index = 0;
    const auto read = std::from_chars(number.data(), number.data() + number.size(), index);
    if (read.ec == std::errc() && listed && listed.IsSequence() && index < listed.size())
      models.push_back(folder / listed[index].as<std::string>());
  }
  return models;
}

Result<LaunchBlock> read_block(const YAML::Node& block) {
  LaunchBlock options;
  if (!block || block.IsNull()) return options;
  if (!block.IsMap()) return Error{"it takes options and their values, as in fire3dv: {uri: shm://ambf}"};
  for (const auto& option : block) {
    if (!option.first.IsScalar()) return Error{"an option's name is no text"};
    const std::string words = option.first.as<std::string>();
    try {
      options[words] = text_of(option.second);
    } catch (const YAML::Exception&) {
      return Error{words + " takes a text, a number, or a list of these"};
    }
  }
  return options;
}

}  // namespace

Result<Launch> read_launch(const std::vector<std::string>& arguments, const fs::path& ambf_root) {
  Launch launch;
  const auto file = value_of(arguments, "launch_file", 0);
  launch.file = file ? fs::path(*file) : ambf_root / "ambf_models/descriptions/launch.yaml";
  launch.name_space = value_of(arguments, "ns", 0).value_or("");
  try {
    const YAML::Node root = YAML::LoadFile(launch.file.string());
    const auto options = read_block(root["fire3dv"]);
    if (!options.ok()) {
      launch.options_fault = launch.file.string() + ": fire3dv: " + options.error().message;
      return launch;
    }
    launch.options = *options;
    const fs::path folder = launch.file.parent_path();
    if (const YAML::Node world = root["world config"]) launch.world = folder / world.as<std::string>();
    launch.models = loaded_models(arguments, root["multibody configs"], folder);
  } catch (const YAML::Exception& error) {
    return Error{launch.file.string() + ": " + error.what()};
  }
  return launch;
}

}  // namespace fire3dv::ambf
