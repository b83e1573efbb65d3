// A check for command-line options that are amounts. CLI11's own range lets NaN pass.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace fire3dv {

inline std::string check_number(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value >= 0 && value <= 1e9
             ? ""
             : text + " is not a number from 0 to 1e9";
}

}  // namespace fire3dv
