// The part of an example's command line that says where it publishes, with what keys, and how long it waits.
#pragma once

#include <fire3dv/client.hpp>

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace examples {

struct LinkOptions {
  std::vector<std::string> to;  // URIs
  fire3dv::Security security;
  double ack_timeout_s = 60;  // of lockstep
};

// Returns --to.
CLI::Option* add_link_options(CLI::App& app, LinkOptions& options);

}  // namespace examples
