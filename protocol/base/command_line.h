// Conventions of all command lines: help with one line for each option, in groups, at most 100 columns; and
// checks of numbers that CLI11's own range lets pass (NaN, infinity).
#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

// One of these words. `type_name` of the option lists them.
inline CLI::Validator one_of(std::vector<std::string> words) {
  return CLI::IsMember(std::move(words)).description("");
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
