// What AMBF was started with, as far as the plugin needs it: without a window AMBF makes no cameras, so their
// definitions are read where AMBF would have read them. Everything here was read by AMBF before the plugin
// was loaded.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "adapters/ambf/options.h"
#include "protocol/error.h"

namespace fire3dv::ambf {

struct Launch {
  std::filesystem::path file;
  std::filesystem::path world;                // empty: the launch file names none
  std::vector<std::filesystem::path> models;  // those that were loaded, in AMBF's order
  std::string name_space;                     // --ns: stands before all names
  LaunchBlock options;                        // the block `fire3dv`
  std::string options_fault;                  // a sentence: the block cannot be read; the rest was not tried
};

// arguments: AMBF's own, with the program's name first. ambf_root: where the default launch file lies.
Result<Launch> read_launch(const std::vector<std::string>& arguments, const std::filesystem::path& ambf_root);

}  // namespace fire3dv::ambf
