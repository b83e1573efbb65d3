// Command-line conventions of the examples: one help line per option, stream URIs, keys and the lockstep
// timeout.
#pragma once

#include <fire3dv/client.hpp>

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace examples {

struct LinkOptions {
  std::vector<std::string> to;  // URIs
  fire3dv::Security security;
  double ack_timeout_s = 60;  // lockstep timeout
};

// Sets the format of --help: one line per option, in groups, at most 100 columns. usage: the arguments.
void set_help(CLI::App& app, const std::string& usage);

// A range that --help does not print.
template <typename T>
CLI::Validator in_range(T least, T most) {
  return CLI::Range(least, most).description("");
}

// Returns --to.
CLI::Option* add_link_options(CLI::App& app, LinkOptions& options);

}  // namespace examples
