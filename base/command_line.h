// Conventions of all command lines: help with one line for each option, in groups, at most 100 columns;
// --version; suggestions for unknown options; and checks of numbers that CLI11's own range lets pass (NaN,
// infinity).
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/build_info.h"
#include "base/nearest_names.h"

namespace fire3dv {

// Prints "  --name VALUE       what it sets (default: x)". An option of two names shows the first: the second
// is one that an earlier version had.
class HelpFormatter : public CLI::Formatter {
 public:
  static constexpr size_t kColumn = 30;

  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string left = "  " + name_of(*option, is_positional);
    if (!option->get_type_name().empty() && option->get_items_expected_max() > 0 && !is_positional)
      left += " " + option->get_type_name();
    left += left.size() < kColumn ? std::string(kColumn - left.size(), ' ') : "  ";
    const std::string& initial = option->get_default_str();
    return left + option->get_description() + (initial.empty() ? "" : " (default: " + initial + ")") + "\n";
  }
  std::string make_usage(const CLI::App* app, std::string name) const override {
    return "Usage: " + (name.empty() ? app->get_name() : name) + " " + usage_ + "\n\n";
  }
  explicit HelpFormatter(std::string usage) : usage_(std::move(usage)) {}

 private:
  static std::string name_of(const CLI::Option& option, bool is_positional) {
    if (is_positional) return option.get_name(true);
    const std::vector<std::string>& names = option.get_lnames();
    const bool is_help = !names.empty() && names.front() == "help";
    if (names.empty()) return option.get_name();
    return (is_help ? "-h, --" : "--") + names.front();
  }

  std::string usage_;
};

// The long option that a mistyped name without dashes stands for; empty: none is close.
inline std::string closest_option(const CLI::App& app, const std::string& name) {
  std::string closest;
  size_t least = std::max<size_t>(1, name.size() / 3) + 1;
  const auto look = [&](const CLI::App& commands) {
    for (const CLI::Option* option : commands.get_options()) {
      for (const std::string& known : option->get_lnames()) {
        const bool is_start = name.size() >= 3 && known.starts_with(name);
        const size_t distance = is_start ? 1 : edit_distance(name, known);
        if (distance < least) closest = known;
        least = std::min(least, distance);
      }
    }
  };
  look(app);
  for (const CLI::App* command : app.get_subcommands()) look(*command);
  return closest;
}

// Text of a usage error. Names all unknown long options, each with the closest known one, else the first
// argument too many.
inline std::string usage_text(const CLI::App& app, const CLI::Error& error) {
  std::string text;
  for (const std::string& word : app.remaining(true)) {
    if (!word.starts_with("--") || word.size() == 2) continue;
    const std::string name = word.substr(2, word.find('=') - 2);
    const std::string closest = closest_option(app, name);
    text += (text.empty() ? "unknown option --" : "; unknown option --") + name;
    if (!closest.empty()) text += ", did you mean --" + closest + "?";
  }
  if (!text.empty()) return text;
  const std::vector<std::string> rest = app.remaining(true);
  if (rest.empty()) return error.what();
  return "unexpected argument \"" + rest.front() + "\"; write names with spaces in quotes";
}

// Sets the format of --help. usage: what follows the name of the program.
inline void set_help(CLI::App& app, std::string usage) {
  app.formatter(std::make_shared<HelpFormatter>(std::move(usage)));
  app.set_help_flag("-h,--help", "print this help and exit");
}

// Sets --help, --version and the text of usage errors of a program, not of its subcommands. Call it when the
// program's name is set.
inline void set_program_flags(CLI::App& app) {
  app.set_help_flag("-h,--help", "print this help and exit");
  const std::string version = app.get_name() + " " + kVersion + " (commit " + kCommit + ")\n" + kFeatures;
  app.set_version_flag("--version", version, "print version, commit and features, and exit");
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    const std::string name = failed->get_name();
    return name + ": error: " + usage_text(*failed, error) + " (see " + name + " --help)\n";
  });
}

// One of these words. `type_name` of the option lists them.
inline CLI::Validator one_of(std::vector<std::string> words) {
  return CLI::IsMember(std::move(words)).description("");
}

// A number in this range, which --help does not print.
template <typename T>
CLI::Validator in_range(T least, T most) {
  return CLI::Range(least, most).description("");
}

// Options of one section of --help. Values are the defaults, and outlive the parsing; type_name stands for
// the value in --help.
class OptionGroup {
 public:
  // title: of the section; empty: that of options without one.
  explicit OptionGroup(CLI::App& app, std::string title = "") : app_(app), title_(std::move(title)) {}

  // --help shows the default unless it is empty or 0.
  template <typename T>
  CLI::Option* add(const char* names, T& value, const std::string& type_name, const std::string& help) {
    CLI::Option* const option = in_section(app_.add_option(names, value, help)->type_name(type_name));
    if constexpr (requires { value.empty(); }) {
      if (!value.empty()) option->capture_default_str();
    } else if constexpr (requires { value != T{}; }) {
      if (value != T{}) option->capture_default_str();
    }
    return option;
  }
  // Each use of the option adds one value.
  template <typename T>
  CLI::Option* add_repeatable(const char* names, std::vector<T>& values, const std::string& type_name,
                              const std::string& help) {
    return add(names, values, type_name, help)->allow_extra_args(false);
  }
  // words: "on|off".
  CLI::Option* add_choice(const char* names, std::string& value, const std::string& words,
                          const std::string& help) {
    return add(names, value, words, help)->check(one_of(CLI::detail::split(words, '|')));
  }
  template <typename T>
  CLI::Option* add_flag(const char* names, T& value, const std::string& help) {
    return in_section(app_.add_flag(names, value, help));
  }

 private:
  CLI::Option* in_section(CLI::Option* option) const {
    return title_.empty() ? option : option->group(title_);
  }

  CLI::App& app_;
  std::string title_;
};

// Options of a client's security: names of files.
inline void add_client_security(CLI::App& app, std::string& udp_key, std::string& tls_ca,
                                std::string& tls_certificate, std::string& tls_key,
                                const char* title = "Security") {
  OptionGroup group(app, title);
  group.add("--key-file", udp_key, "FILE", "udp: pre-shared key, 64 hexadecimal digits");
  group.add("--tls-ca", tls_ca, "FILE", "tls: trusted certificates (PEM)");
  group.add("--tls-cert", tls_certificate, "FILE", "tls: client certificate (PEM)");
  group.add("--tls-key", tls_key, "FILE", "tls: private key of that certificate (PEM)");
}

inline std::function<std::string(const std::string&)> number_between(double least, double most) {
  return [least, most](const std::string& text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool good =
        error == std::errc() && end == text.data() + text.size() && value >= least && value <= most;
    return good ? ""
                : text + " is not a number from " + CLI::detail::to_string(least) + " to " +
                      CLI::detail::to_string(most);
  };
}

// An amount: a number from 0 to 1e9.
inline std::string check_number(const std::string& text) {
  return number_between(0, 1e9)(text);
}

}  // namespace fire3dv
