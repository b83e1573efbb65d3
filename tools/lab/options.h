// Command-line conventions of the lab programs: the help format of the installed programs, and ranges that
// the help does not print.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>

#include "base/command_line.h"

namespace fire3dv::lab {

inline void set_help(CLI::App& app, std::string usage) {
  app.formatter(std::make_shared<HelpFormatter>(std::move(usage)));
  app.set_help_flag("-h,--help", "print this help and exit");
}

template <typename T>
CLI::Validator in_range(T least, T most) {
  return CLI::Range(least, most).description("");
}

// Adds an option whose default is the present value.
template <typename T>
CLI::Option* add_value(CLI::App& app, const char* names, T& value, const char* type, const char* text) {
  return app.add_option(names, value, text)->type_name(type)->capture_default_str();
}

}  // namespace fire3dv::lab
