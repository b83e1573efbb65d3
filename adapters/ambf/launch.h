// AMBF's command line and launch file, as far as the plugin needs them. AMBF creates no cameras without a
// window, so the plugin reads their definitions from the same files. AMBF has read all of them before it
// loads the plugin.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "adapters/ambf/options.h"
#include "protocol/base/error.h"

namespace fire3dv::ambf {

struct Launch {
  std::filesystem::path file;
  std::filesystem::path world;                // empty: the launch file has none
  std::vector<std::filesystem::path> models;  // loaded models, in AMBF's order
  std::string name_space;                     // --ns: prefix of all names
  LaunchBlock options;                        // block `fire3dv`
  std::string options_fault;                  // error message: the block is unreadable; the other files were
                                              // not read
};

// arguments: AMBF's argv, program name included. ambf_root: folder of the default launch file.
Result<Launch> read_launch(const std::vector<std::string>& arguments, const std::filesystem::path& ambf_root);

}  // namespace fire3dv::ambf
