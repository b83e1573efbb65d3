#include "adapters/ambf/options.h"

#include <yaml-cpp/yaml.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <optional>

#include "base/numbers.h"

namespace fire3dv::ambf {

namespace {

// Option: words separated by blanks, setter, and accepted values.
struct OptionRule {
  const char* words;
  std::function<bool(Options&, const std::string&)> set;
  const char* takes;
};

// Lowest and highest rate. A period above 1000 s is likely a typo; the upper end keeps periods in whole
// nanoseconds.
constexpr double kLowestRateHz = 1e-3, kHighestRateHz = 1e6;

// Parses with a decimal point, independent of the locale of the AMBF process.
bool read_rate(const std::string& text, double& rate_hz) {
  const std::optional<double> value = parse_number<double>(text);
  if (!value || !(*value >= 0 && *value <= kHighestRateHz)) return false;
  if (*value > 0 && *value < kLowestRateHz) return false;
  rate_hz = *value;
  return true;
}

bool read_uris(const std::string& text, std::vector<std::string>& uris) {
  uris.clear();
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    if (end == begin) return false;
    uris.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return true;
}

bool read_names(const std::string& text, Options::Names& names) {
  if (text != "key" && text != "name") return false;
  names = text == "key" ? Options::Names::key : Options::Names::name;
  return true;
}

auto file_into(std::string Options::*member) {
  return [member](Options& options, const std::string& text) {
    options.*member = text;
    return !text.empty();
  };
}

const std::vector<OptionRule>& known_options() {
  static const std::vector<OptionRule> known{
      {"uri", [](Options& o, const std::string& text) { return read_uris(text, o.uris); },
       "shm://NAME, tcp://HOST:PORT, tls://HOST:PORT or udp://HOST:PORT, or several with commas between"},
      {"rate", [](Options& o, const std::string& text) { return read_rate(text, o.rate_hz); },
       "frames a second, 0.001 to 1000000, or 0 for every physics step"},
      {"vertex rate", [](Options& o, const std::string& text) { return read_rate(text, o.vertex_rate_hz); },
       "times a second that soft bodies are sent, 0.001 to 1000000, or 0 for every frame"},
      {"names", [](Options& o, const std::string& text) { return read_names(text, o.names); },
       "key (as AMBF's maps and fire3dv-convert have it) or name (as ROS topics have it)"},
      {"key file", file_into(&Options::key_file), "a file with the key of udp://"},
      {"tls ca file", file_into(&Options::tls_ca_file), "a file of certificates to trust"},
      {"tls certificate file", file_into(&Options::tls_certificate_file), "a certificate file"},
      {"tls key file", file_into(&Options::tls_key_file), "the file of the certificate's key"}};
  return known;
}

std::string joined(const char* words, char between) {
  std::string text = words;
  std::replace(text.begin(), text.end(), ' ', between);
  return text;
}

std::string flag_of(const char* words) {
  return "--fire3dv-" + joined(words, '-');
}

std::string variable_of(const char* words) {
  std::string name = "FIRE3DV_AMBF_" + joined(words, '_');
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

Error refused(const std::string& where, const std::string& text, const OptionRule& option) {
  return {where + " is '" + text + "'; it takes " + option.takes};
}

// Reads --fire3dv-* arguments. An unknown one is an error, so that typos do not go unnoticed.
Result<void> read_arguments(const std::vector<std::string>& arguments, Options& options) {
  const std::string prefix = "--fire3dv-";
  for (size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i].compare(0, prefix.size(), prefix) != 0) continue;
    const size_t equals = arguments[i].find('=');
    const std::string flag = arguments[i].substr(0, equals);
    const auto option = std::find_if(known_options().begin(), known_options().end(),
                                     [&](const OptionRule& known) { return flag_of(known.words) == flag; });
    if (option == known_options().end()) {
      std::string all;
      for (const OptionRule& known : known_options()) all += (all.empty() ? "" : ", ") + flag_of(known.words);
      return Error{flag + " is not an option of the plugin; there are " + all};
    }
    if (equals == std::string::npos && i + 1 == arguments.size())
      return Error{flag + " needs a value: " + option->takes};
    const std::string value = equals == std::string::npos ? arguments[++i] : arguments[i].substr(equals + 1);
    if (!option->set(options, value)) return refused(flag, value, *option);
  }
  return {};
}

}  // namespace

Result<Options> read_options(const std::vector<std::string>& arguments,
                             const std::function<const char*(const char*)>& environment,
                             const LaunchBlock& launch) {
  Options options;
  for (const auto& entry : launch) {
    const auto& words = entry.first;  // clang 14 captures no structured bindings
    const auto& value = entry.second;
    const auto option = std::find_if(known_options().begin(), known_options().end(),
                                     [&](const OptionRule& known) { return words == known.words; });
    const std::string where = "the launch file's fire3dv: " + words;
    if (option == known_options().end()) {
      std::string all;
      for (const OptionRule& known : known_options())
        all += (all.empty() ? "" : ", ") + std::string(known.words);
      return Error{where + " is not an option of the plugin; there are " + all};
    }
    if (!option->set(options, value)) return refused(where, value, *option);
  }
  for (const OptionRule& option : known_options()) {
    const std::string variable = variable_of(option.words);
    const char* const value = environment(variable.c_str());
    if (value && !option.set(options, value)) return refused(variable, value, option);
  }
  const auto read = read_arguments(arguments, options);
  if (!read.ok()) return read.error();
  return options;
}

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
    if (!option.first.IsScalar()) return Error{"an option's name is not text"};
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
