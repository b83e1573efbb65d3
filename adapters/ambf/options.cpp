#include "adapters/ambf/options.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>

namespace fire3dv::ambf {
namespace {

// Option: words separated by blanks, setter, and accepted values.
struct Known {
  const char* words;
  std::function<bool(Options&, const std::string&)> set;
  const char* takes;
};

// Lowest and highest rate. A period above 1000 s is likely a typo; the upper end keeps periods in whole
// nanoseconds.
constexpr double kLowestRateHz = 1e-3, kHighestRateHz = 1e6;

// Parses with a decimal point, independent of the locale of the AMBF process.
bool read_rate(const std::string& text, double& rate_hz) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= 0 && value <= kHighestRateHz))
    return false;
  if (value > 0 && value < kLowestRateHz) return false;
  rate_hz = value;
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

const std::vector<Known>& known_options() {
  static const std::vector<Known> known{
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

Error refused(const std::string& where, const std::string& text, const Known& option) {
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
                                     [&](const Known& known) { return flag_of(known.words) == flag; });
    if (option == known_options().end()) {
      std::string all;
      for (const Known& known : known_options()) all += (all.empty() ? "" : ", ") + flag_of(known.words);
      return Error{flag + " is no option of the plugin; there are " + all};
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
                                     [&](const Known& known) { return words == known.words; });
    const std::string where = "the launch file's fire3dv: " + words;
    if (option == known_options().end()) {
      std::string all;
      for (const Known& known : known_options()) all += (all.empty() ? "" : ", ") + std::string(known.words);
      return Error{where + " is no option of the plugin; there are " + all};
    }
    if (!option->set(options, value)) return refused(where, value, *option);
  }
  for (const Known& option : known_options()) {
    const std::string variable = variable_of(option.words);
    const char* const value = environment(variable.c_str());
    if (value && !option.set(options, value)) return refused(variable, value, option);
  }
  const auto read = read_arguments(arguments, options);
  if (!read.ok()) return read.error();
  return options;
}

}  // namespace fire3dv::ambf
