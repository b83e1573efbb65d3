// Command `fire3dv doctor`: its options and main function.
#pragma once

#include <filesystem>
#include <variant>

#include "renderer/doctor/gather.h"

namespace fire3dv::doctor {

struct Options {
  Addresses addresses;
  bool json = false;
  bool bench = false;
  std::filesystem::path report;  // empty: none
  double time_limit_s = 20;      // of each experiment
};

// Returns options or an exit code. argv[1] is the subcommand.
std::variant<Options, int> parse_options(int argc, char** argv);

// Prints the report or the table of times. Returns the exit code: 1 if anything is broken.
int run(const Options& options);

}  // namespace fire3dv::doctor
