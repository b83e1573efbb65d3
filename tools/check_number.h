// Checks for command-line options that are amounts. CLI11's own range lets NaN pass.
#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <functional>
#include <string>

namespace fire3dv {

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

inline std::string check_number(const std::string& text) {
  return number_between(0, 1e9)(text);
}

}  // namespace fire3dv
