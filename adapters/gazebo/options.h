// Command line of fire3dv-gazebo.
#pragma once

#include <filesystem>
#include <fire3dv/client.hpp>
#include <optional>
#include <string>
#include <vector>

#include "adapters/gazebo/stream/session.h"
#include "adapters/gazebo/wire/node.h"

namespace fire3dv::gazebo {

struct Options {
  std::vector<std::string> uris;
  Security security;
  std::string stream_name = "gazebo";
  NodeOptions node;
  SessionOptions session;
  std::vector<std::filesystem::path> resource_folders;
};

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<Options> parse_options(int argc, char** argv, int* exit_code);

}  // namespace fire3dv::gazebo
