// Command-line options common to the examples: stream URIs, keys and the lockstep timeout.
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

// Returns --to.
CLI::Option* add_link_options(CLI::App& app, LinkOptions& options);

}  // namespace examples
