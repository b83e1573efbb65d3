// Plugin options (stream URIs, rates, node names, keys), and AMBF's command line and launch file. Sources of
// options in order of precedence: AMBF's command line (--fire3dv-key-file F or --fire3dv-key-file=F; AMBF
// ignores unknown options), the environment (FIRE3DV_AMBF_KEY_FILE), the launch file
// (`fire3dv: {key file: F}`).
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::ambf {

struct Options {
  enum class Names {
    key,   // AMBF's map key: namespace and the ADF identifier; fire3dv-convert writes these
    name,  // namespace and `name`: what ROS topics are called
  };

  std::vector<std::string> uris{"shm://ambf"};
  double rate_hz = 0;          // hertz of wall time; 0: every physics step
  double vertex_rate_hz = 30;  // hertz; soft body vertices cost more than poses
  Names names = Names::key;
  std::string key_file, tls_ca_file, tls_certificate_file, tls_key_file;
};

// Entries of the launch file's block; lists of URIs are joined by commas.
using LaunchBlock = std::map<std::string, std::string>;

// Errors name the option, its source and the accepted values. environment: like getenv.
Result<Options> read_options(const std::vector<std::string>& arguments,
                             const std::function<const char*(const char*)>& environment,
                             const LaunchBlock& launch);

// AMBF's command line and launch file, as far as the plugin needs them. AMBF creates no cameras without a
// window, so the plugin reads their definitions from the same files. AMBF has read all of them before it
// loads the plugin.
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
