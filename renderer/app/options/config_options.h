// Options of a command line and a configuration file together.
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "renderer/app/options/config_file.h"
#include "renderer/app/options/options.h"

namespace fire3dv::app {

constexpr int kUsageExitCode = 2;

struct UsageError {
  int exit_code = 0;
  std::string text;  // empty: help or version was printed
};

// Options of a command line whose presence or absence matters to the configuration file. Long names without
// dashes.
struct GivenOptions {
  std::vector<std::string> present;
  std::vector<std::string> excluded;  // by those
  std::string config;                 // value of --config
};

enum class OptionChecks : uint8_t {
  words,  // each word alone
  all,    // and all options together
};

// Parses the words after the program's name.
using ParseWords = std::function<std::variant<Options, UsageError>(const std::vector<std::string>& words,
                                                                   OptionChecks checks, GivenOptions* given)>;

// Parses these words and the lines of the configuration file that they do not overrule: options that the
// words hold or exclude. A line that is right in itself but contradicts the words is left out; notes says so.
std::variant<Options, UsageError> parse_with_config(
    const ParseWords& parse, const std::vector<std::string>& words,
    const std::function<const char*(const char*)>& environment, std::vector<std::string>& notes);

}  // namespace fire3dv::app
