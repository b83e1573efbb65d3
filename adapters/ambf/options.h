// What the user may choose: where frames go, how often, and by which names. The same words everywhere: on
// AMBF's command line (--fire3dv-key-file F or --fire3dv-key-file=F; AMBF lets options pass that it does not
// know), in the environment (FIRE3DV_AMBF_KEY_FILE) and in the launch file (`fire3dv: {key file: F}`). The
// command line wins, then the environment.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::ambf {

struct Options {
  enum class Names {
    key,   // as AMBF's maps have it: namespace and the description's identifier; fire3dv-convert writes these
    name,  // namespace and `name`: what ROS topics are called
  };

  std::vector<std::string> uris{"shm://ambf"};
  double rate_hz = 0;          // frames a second of wall time; 0: every physics step
  double vertex_rate_hz = 30;  // of soft bodies, whose vertices cost more than poses
  Names names = Names::key;
  std::string key_file, tls_ca_file, tls_certificate_file, tls_key_file;
};

// Words and values of the launch file's block: lists (of URIs) joined by commas.
using LaunchBlock = std::map<std::string, std::string>;

// The error names the option, where it stood, and what it takes. environment: like getenv.
Result<Options> read_options(const std::vector<std::string>& arguments,
                             const std::function<const char*(const char*)>& environment,
                             const LaunchBlock& launch);

}  // namespace fire3dv::ambf
